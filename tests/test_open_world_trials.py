"""A few trials of the open world, judged against answers that are known: they test the judge, not the diagnosis.

Recordings are short, on other seeds than any reported figure uses. What the search itself finds is the question of the long run,
``studies/open_world/run.py``, which takes hours; nothing here depends on it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import physident as pid
from studies.open_world import bench, drawing, judge, sizing, trial
from studies.open_world.background import Cable
from studies.open_world.causes import TIERS
from studies.open_world.drawing import drawn
from studies.open_world.pooled import pooled
from studies.open_world.scoring import score, score_outside, score_twin
from studies.open_world.summary import FIGURES, figure, share, summary, table
from studies.open_world.taken import Taken
from studies.open_world.trial import Kind, Scene, Trial, outside_of, parts, scene_of
from tests.plant import open_plant
from tests.plant_mujoco import plant as mujoco_plant

pytestmark = pytest.mark.slow

GROUP = 9
DURATION = 6.0  # s
# kind, number, arm, question: two singles, a pair and a cause from outside on each plant's arms, even ones before pinocchio
JOBS: dict[str, tuple[Kind, int, int, str]] = {
    "viscous": ("single", 1, 12, "different"),
    "spring": ("single", 14, 15, "different"),
    "refitted": ("single", 10, 4, "missing"),
    "weak": ("single", 12, 5, "nominal"),
    "pair": ("pair", 1, 12, "different"),
    "outside": ("outside", 1, 5, "nominal"),
}


@dataclass(frozen=True, eq=False)
class Known:
    """A trial with its recordings."""

    scene: Scene
    trial: Trial
    changed: tuple[Taken, ...]


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Recordings made anew, of short motions, in steps twice as long as the study's: an arm's twin moves in the same ones."""
    cached: tuple[Any, ...] = (bench.bench, bench.identified)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bench, "CACHE", tmp_path_factory.mktemp("open"))
        for module in (bench, drawing, sizing):
            patch.setattr(module, "DURATION", DURATION)
        for plant in (open_plant, mujoco_plant):
            patch.setattr(plant, "STEP", 2 * plant.STEP)
        for one in cached:
            one.cache_clear()
        yield
    for one in cached:
        one.cache_clear()


@pytest.fixture(scope="module")
def made(world: None) -> Callable[[str], Known]:
    """A trial by its name, made once."""
    known: dict[str, Known] = {}

    def get(name: str) -> Known:
        if name not in known:
            scene = scene_of("first", GROUP, *JOBS[name])
            one = drawn(scene)
            known[name] = Known(scene, one, scene.changed(one.tag, *parts(scene, one)))
        return known[name]

    return get


def finding(effect: str, joints: tuple[int, ...], *rivals: tuple[str, tuple[int, ...]], **more: Any) -> Any:
    """A finding as a diagnosis has it, as far as it is judged."""
    others = tuple(SimpleNamespace(effect=name, joints=where) for name, where in rivals)
    values = tuple(
        SimpleNamespace(name=effect, joint=j, change=1.0, change_interval95=(0.5, 1.5)) for j in joints or (0,)
    )
    return SimpleNamespace(effect=effect, joints=joints, rivals=others, parameters=values, **more)


def answer(*findings: Any, described: tuple[int, ...] = (), estimate: Any = None) -> Any:
    """A diagnosis that somebody made up."""
    rest = tuple(SimpleNamespace(joint=j, description="made up") for j in described)
    return SimpleNamespace(findings=findings, structured=rest, may_hide=(), estimate=estimate, verdict="made up")


def truth(known: Known) -> list[Any]:
    """Findings that name what was hidden, with its value."""
    found = []
    for h in known.trial.hidden:
        f = finding(h.effect, h.joints)
        ends = (0.9 * h.size, 1.2 * h.size)
        joint = h.joints[0] if h.joints else 0
        f.parameters = (SimpleNamespace(name=h.effect, joint=joint, change=h.size, change_interval95=ends),)
        found.append(f)
    return found


def extended(known: Known) -> pid.Model:
    """The model that was diagnosed, with what was hidden in its true size."""
    start = known.scene.model.model if isinstance(known.scene.model, pid.Estimate) else known.scene.model
    (h,) = known.trial.hidden
    names = [column.name for column in start.columns]
    if f"{h.effect}_{h.joints[0]}" in names:
        theta = start.theta.copy()
        theta[names.index(f"{h.effect}_{h.joints[0]}")] += h.size
        return pid.Model(start.robot, start.effects, theta)
    more = pid.CATALOGUE[h.effect](joints=h.joints)
    return pid.Model(start.robot, (*start.effects, more), np.append(start.theta, h.size))


def judged(known: Known, *findings: Any, estimate: Any = None) -> Any:
    return score(known.scene, known.trial, known.changed, answer(*findings, estimate=estimate))


@pytest.mark.parametrize("name", list(JOBS))
def test_a_trial_is_drawn_and_of_its_tier(made: Callable[[str], Known], name: str) -> None:
    known = made(name)
    kind, number, arm, question = JOBS[name]
    one = known.trial
    assert (one.kind, one.arm, one.question, one.group) == (kind, arm, question, GROUP)
    assert known.scene.bench.plant.name == ("pinocchio", "mujoco")[arm % 2]
    assert len(one.hidden) == {"single": 1, "pair": 2, "outside": 0}[kind]
    assert one.tier == trial.tier_of(kind, number if kind != "outside" else 0)
    low, high = TIERS[one.tier]
    assert one.reduction >= low
    assert one.reduction <= high or kind == "pair"  # of which each alone is in its tier
    saved = Trial.load(known.scene.folder / "trial.json")
    assert saved == one
    assert len(known.changed) == 3
    assert all(np.isfinite(t.recording.effort).all() for t in known.changed)


def taken_away(known: Known) -> tuple[Any, Any]:
    """RMS (n,) [N m] of what the model leaves of the held-out recording, and of it without its hidden torque."""
    held = known.changed[2]
    bare = replace(held, recording=replace(held.recording, effort=held.recording.effort - held.alone.effort))
    before, after = (sizing.residual_rms(known.scene.bench, known.scene.model, [taken]) for taken in (held, bare))
    return before, after


@pytest.mark.parametrize("name", ["viscous", "spring"])
def test_without_its_hidden_torque_a_recording_is_its_clean_twin(made: Callable[[str], Known], name: str) -> None:
    known = made(name)
    scene, one = known.scene, known.trial
    clean = scene.bench.record(scene.folder / "clean_2", scene.seed(2), scene.warmer(2))
    before, after = taken_away(known)
    np.testing.assert_allclose(after, sizing.residual_rms(scene.bench, scene.model, [clean]), rtol=0.01)
    assert before[one.joint - 1] > after[one.joint - 1]
    # the tier is by definition that of a hidden torque that has nothing in common with what the model leaves
    hidden = sizing.hidden_rms(scene.bench, known.changed[2:], False)
    assert one.reduction == pytest.approx(sizing.Oracle.of(hidden, scene.noise).percent)


def test_a_twin_is_the_same_motion_with_nothing_hidden(made: Callable[[str], Known]) -> None:
    for name in ("viscous", "spring", "refitted", "weak"):
        known = made(name)
        assert len(known.scene.clean) == 2
        for clean, changed in zip(known.scene.clean, known.changed[:2], strict=True):
            assert not clean.hidden.any()
            assert clean.motion == changed.motion
            np.testing.assert_allclose(clean.recording.time, changed.recording.time)
            assert np.abs(clean.recording.q - changed.recording.q).max() < 0.1
            assert clean.recording.sha256 != changed.recording.sha256


@pytest.mark.parametrize("name", ["viscous", "spring", "refitted", "weak", "pair"])
def test_the_truth_gets_full_marks(made: Callable[[str], Known], name: str) -> None:
    known = made(name)
    findings = truth(known)
    s = judged(known, *findings)
    assert (s.first, s.alone, s.size, s.named, s.others, s.own, s.lesser) == (True, True, 1, True, 0, 0, False)
    if name != "pair":
        assert s.error == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("name", ["viscous", "spring"])
def test_the_true_model_gains_what_taking_the_torque_away_gains(made: Callable[[str], Known], name: str) -> None:
    known = made(name)
    before, after = taken_away(known)
    s = judged(known, *truth(known), estimate=extended(known))
    assert s.gain == pytest.approx(100 * (1 - after / before)[known.trial.joint - 1], abs=0.5)
    assert s.gain > 0
    assert judged(known, *truth(known)).gain is None


def test_a_value_is_judged_by_its_error_and_its_interval(made: Callable[[str], Known]) -> None:
    known = made("spring")
    (f,) = truth(known)
    f.parameters[0].change *= 1.2
    s = judged(known, f)
    assert s.error == pytest.approx(20.0)
    assert s.interval == pytest.approx((0.9, 1.2))
    row = {"kind": "single", "tier": "strong", "score": {"interval": s.interval}}
    missed, several = (
        {"kind": "single", "tier": "middle", "score": {"interval": ends}} for ends in ((1.01, 1.2), None)
    )
    assert figure("interval", [row, missed, several]) == share([True, False])


@pytest.mark.parametrize("name", ["viscous", "spring", "refitted", "weak", "pair"])
def test_silence_misses_what_was_hidden(made: Callable[[str], Known], name: str) -> None:
    s = judged(made(name))
    assert (s.first, s.alone, s.size, s.named, s.others, s.error, s.told) == (
        False,
        False,
        0,
        False,
        0,
        None,
        "nothing",
    )


def test_what_is_named_beside_the_truth_is_counted(made: Callable[[str], Known]) -> None:
    known = made("spring")
    (right,) = truth(known)
    wrong = finding("torque_constant", (2,))
    s = judged(known, right, wrong)
    assert (s.first, s.alone, s.named, s.others) == (True, True, True, 1)
    s = judged(known, wrong, right)
    assert (s.first, s.named, s.others) == (False, True, 1)
    # a finding of two joints claims both, of which one is right; the truth elsewhere is no truth
    s = judged(known, finding("joint_spring", (1, 2)))
    assert (s.first, s.named, s.others) == (True, True, 1)
    s = judged(known, finding("joint_spring", (2,)))
    assert (s.first, s.named, s.others) == (False, False, 1)


def test_a_class_of_rivals_is_first_but_not_alone(made: Callable[[str], Known]) -> None:
    s = judged(made("spring"), finding("torque_ripple", (1,), ("joint_spring", (1,))))
    assert (s.first, s.alone, s.size, s.named, s.others, s.error) == (True, False, 2, True, 0, None)


def test_less_than_a_cause_is_missed(made: Callable[[str], Known]) -> None:
    s = judged(made("spring"), finding("joint_spring", (1,), grade="hint"))
    assert (s.first, s.named, s.lesser, s.others) == (False, False, True, 0)


def test_half_a_pair_is_not_both(made: Callable[[str], Known]) -> None:
    known = made("pair")
    s = judged(known, truth(known)[1])
    assert (s.first, s.named, s.others) == (True, False, 0)


def test_true_friction_that_nobody_hid_is_no_false_cause(made: Callable[[str], Known]) -> None:
    """Bristles are in the arm; a model that is fitted to the recordings misses them, one that was identified before has them."""
    known, bristles = made("refitted"), finding("presliding_hysteresis", (2,))
    assert known.scene.bench.arm.friction.kind == "bristle"
    s = judged(known, bristles, *truth(known))
    assert (s.first, s.others, s.own) == (True, 0, 1)
    assert score_twin(known.scene, answer(bristles)).own == 1
    s = judged(made("viscous"), bristles)
    assert (s.others, s.own) == (1, 0)


def test_twins_want_silence(made: Callable[[str], Known]) -> None:
    scene = made("viscous").scene
    silent, accused = (
        score_twin(scene, answer(*f)) for f in ((), (finding("payload", ()), finding("warm_up", (1, 2))))
    )
    assert (silent.false, silent.own, silent.described) == (0, 0, False)
    assert accused.false == 3
    described = score_twin(scene, answer(finding("payload", (), grade="hint"), described=(2,)))
    assert (described.false, described.described) == (0, True)


def test_outside_the_catalogue_a_description_is_right_and_every_name_wrong(made: Callable[[str], Known]) -> None:
    known = made("outside")
    cause: Any = outside_of(known.scene, known.trial.outside, known.trial.draw)
    assert cause.kind == "gas_spring"
    (there,) = cause.joints
    elsewhere = 1 if there != 1 else 2

    def outcome(*findings: Any, described: tuple[int, ...] = (), of: Any = cause) -> tuple[bool, ...]:
        told = answer(*findings, described=described)
        s = score_outside(known.scene, known.trial, of, known.changed, told, answer)
        return s.wrong, s.joint, s.right_description, s.silent

    assert outcome() == (False, False, False, True)
    assert outcome(described=(there,)) == (False, True, True, False)
    assert outcome(described=(elsewhere,)) == (False, False, False, False)
    assert outcome(finding("torque_constant", (there,)), described=(there,)) == (True, True, True, False)
    assert outcome(finding("torque_constant", (elsewhere,))) == (True, False, False, False)
    assert outcome(finding("torque_constant", (there,), grade="hint")) == (False, True, True, False)
    # a gas spring's torque depends on position: a learned curve that says so is no name, and right where it stands
    assert outcome(finding("learned_position", (there,))) == (False, True, True, False)
    assert outcome(finding("learned_time", (there,))) == (True, True, False, False)
    assert outcome(finding("learned_load", (elsewhere,))) == (True, False, False, False)
    # a sensor that follows slowly is late, and a bend of its channel may be called a curve over the load or the torque
    slow, bent = replace(cause, kind="sensor_lag", variable="other"), replace(cause, kind="saturation", variable="load")
    assert outcome(finding("torque_delay", (there,)), of=slow) == (False, True, True, False)
    assert outcome(finding("torque_delay", (elsewhere,)), of=slow) == (True, False, False, False)
    for name in ("learned_load", "learned_torque"):
        assert outcome(finding(name, (there,)), of=bent) == (False, True, True, False)


def test_beside_a_cause_from_outside_the_background_keeps_its_names(made: Callable[[str], Known]) -> None:
    """A cable on every joint: where the cause acts, its name is a wrong one of the cause unless the arm without it is given it too."""
    known = made("outside")
    cause: Any = outside_of(known.scene, known.trial.outside, known.trial.draw)
    (there,) = cause.joints
    elsewhere = 1 if there != 1 else 2
    one = known.scene.bench
    ones = np.ones(one.arm.joints)
    cable = Cable(size=ones, neighbour=ones.astype(int), share=ones, middle=ones, slack=ones, bend=ones)
    scene = SimpleNamespace(
        bench=SimpleNamespace(arm=replace(one.arm, background=(cable,)), world=one.world),
        question="nominal", refitted=False, warmer=lambda k: 0.0,
    )  # fmt: skip

    def wrong(joint: int, of: Any, *twin: Any) -> bool:
        told = answer(finding("joint_spring", (joint,)))
        return score_outside(scene, known.trial, of, known.changed, told, lambda: answer(*twin)).wrong  # type: ignore[arg-type]

    everywhere = replace(cause, joints=())
    there_too, not_there = finding("joint_spring", (there,)), finding("joint_spring", (elsewhere,))
    assert not wrong(elsewhere, cause)
    assert wrong(there, cause)
    assert wrong(there, cause, not_there)
    assert not wrong(there, cause, there_too)
    assert wrong(elsewhere, everywhere)
    assert not wrong(elsewhere, everywhere, not_there)
    assert wrong(there, cause, finding("joint_spring", (there,), grade="hint"))


def rows_of(monkeypatch: pytest.MonkeyPatch, made: Callable[[str], Known], right: bool) -> list[dict[str, Any]]:
    """Rows of all trials, as a run writes them, of a diagnosis that knows the truth or of one that has it all wrong."""
    rows = []
    for name, (kind, number, _, _) in JOBS.items():
        known = made(name)

        def diagnosed(scene: Scene, taken: tuple[Taken, ...], _: Any, known: Known = known) -> Any:
            clean = taken[0] is scene.clean[0]
            if right:
                there = outside_of(scene, known.trial.outside, known.trial.draw).joints if known.trial.outside else ()
                return answer(*(() if clean else truth(known)), described=there)
            return answer(finding("gravity_tilt", ()))

        monkeypatch.setattr(judge, "open_scene", lambda *_, known=known: known.scene)
        monkeypatch.setattr(judge, "diagnosed", diagnosed)
        rows.append(judge.judge(("first", GROUP, kind, number)))
        assert "failed" not in rows[-1], rows[-1]
        assert judge.line(rows[-1])
    return rows


def test_a_run_of_right_answers_is_a_table_of_full_marks(
    monkeypatch: pytest.MonkeyPatch, made: Callable[[str], Known]
) -> None:
    found = summary(rows_of(monkeypatch, made, right=True))
    percent = {key: found["figures"][key]["percent"] for key in FIGURES}
    full = {"first", "alone", "value", "interval", "weak_first", "both", "pair_first", "outside_joint", "outside_told"}
    assert percent == {key: 100.0 if key in full else 0.0 for key in FIGURES}
    assert found["figures"]["twin_false"]["n"] == 4
    assert sum(cell["first"]["n"] for cell in found["strata"]["plant"].values()) == 3
    assert found["refused"]["percent"] == found["failed"]["percent"] == 0
    assert "right cause first" in table(found)


def test_a_run_of_wrong_answers_is_a_table_of_none(
    monkeypatch: pytest.MonkeyPatch, made: Callable[[str], Known]
) -> None:
    found = summary(rows_of(monkeypatch, made, right=False))
    percent = {key: found["figures"][key]["percent"] for key in FIGURES}
    wrong = {"others", "weak_wrong", "twin_false", "twin_any", "third", "outside_wrong"}
    assert percent == {key: 100.0 if key in wrong else 0.0 for key in FIGURES}


def test_sets_that_are_pooled_are_one_set(monkeypatch: pytest.MonkeyPatch, made: Callable[[str], Known]) -> None:
    right, wrong = (rows_of(monkeypatch, made, right=each) for each in (True, False))
    for some in ([*right[:1], *wrong], right):  # of some strata only one of them has trials
        assert _flat(pooled(summary(right[1:]), summary(some))) == pytest.approx(_flat(summary([*right[1:], *some])))


def _flat(found: Any, name: str = "") -> dict[str, float]:
    """The numbers of nested tables by their whole names."""
    if not isinstance(found, dict):
        return {name: found}
    return {key: value for part in found for key, value in _flat(found[part], f"{name}/{part}").items()}


def test_refusals_and_failures_are_rows_of_their_own(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any) -> Scene:
        raise pid.InputError("too short")

    def fail(*_: Any) -> Scene:
        raise ZeroDivisionError("no wonder")

    rows = []
    for opened in (refuse, fail):
        monkeypatch.setattr(judge, "open_scene", opened)
        rows.append(judge.judge(("first", GROUP, "single", 1)))
    assert rows[0]["refused"] == "InputError: too short"
    assert rows[1]["failed"] == "ZeroDivisionError: no wonder"
    found = summary(rows)
    assert found["refused"]["percent"] == found["failed"]["percent"] == 50.0
    assert found["figures"]["first"]["n"] == 0


def test_a_diagnosis_has_what_the_judge_reads(made: Callable[[str], Known]) -> None:
    """A real one, right or wrong: were a name of the record changed, scores would quietly be those of an empty answer.

    So that there is something to read, every torque is shown a fifth too high.
    """
    known = made("viscous")
    shown = [replace(t.recording, effort=1.2 * t.recording.effort) for t in known.changed[:2]]
    found = pid.diagnose_motion(known.scene.model, shown)
    assert found.findings
    for f in found.findings:
        assert {"effect", "joints", "rivals", "parameters"} <= set(dir(f))
    assert all(1 <= r.joint <= 4 and r.description for r in found.structured)
    assert score(known.scene, known.trial, known.changed, found).verdict == found.verdict
