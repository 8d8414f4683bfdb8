"""One effect takes the place of a patchwork, never of effects that are there; and a search that goes on finding is stopped."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.diagnosis import judged, searched
from physident.diagnosis.grading.grades import BESIDE_OTHERS, is_patchwork, single_cause
from physident.diagnosis.learned import learn
from physident.diagnosis.result.findings import Finding, Grade, Reduction, Rival
from physident.diagnosis.result.wording import wrong_baseline_sentence
from physident.diagnosis.search import forward_search
from physident.diagnosis.search.acceptance import DOUBT, choose_candidate, is_beyond_doubt
from physident.diagnosis.search.candidate_scores import score_candidates
from physident.diagnosis.search.forward_search import search_effects, settled_hypothesis
from physident.diagnosis.search.hypothesis import AcceptedEffect, Hypothesis, state_hypothesis
from physident.diagnosis.search.one_for_many import find_replacement
from physident.diagnosis.statistics.intervals import uncertainty_of
from tests.exact_friction import exact_arm
from tests.opened import opened
from tests.plant import Arm, Sensors, hide, multisine, record
from tests.searched_once import searched_once
from tests.serial_arms import ARMS, swung, urdf
from tests.test_friction_level_of_bristles import LEVEL, recorded

pytestmark = pytest.mark.slow

PATCHWORK = tuple(("link_inertia", (link,)) for link in (3, 4, 5))


@pytest.fixture(scope="module")
def loaded(ur5: pid.Robot, healthy_runs: list[pid.Recording], tmp_path_factory: pytest.TempPathFactory) -> Hypothesis:
    """An arm that carries a load, as a patchwork of three links."""
    path = tmp_path_factory.mktemp("loaded") / "run.csv"
    record(hide(exact_arm(), "payload", (), 0.8), multisine(41), Sensors(), 41, step=2e-3).write_csv(path)
    return opened(ur5, [*healthy_runs[:2], pid.load_recording(path)])


@pytest.fixture(scope="module")
def rubbing(ur5: pid.Robot, healthy_runs: list[pid.Recording]) -> Hypothesis:
    """Dry and viscous friction of joint 3 doubled."""
    v = healthy_runs[2].dq
    assert v is not None
    friction = Arm().friction
    more = (friction.coulomb * np.tanh(v / 0.01) + friction.viscous * v) * (np.arange(6) == 2)
    return opened(ur5, healthy_runs[:3], more)


def accepted(state: Hypothesis, keys: tuple[tuple[str, tuple[int, ...]], ...]) -> tuple[AcceptedEffect, ...]:
    found = {c.key: c for c in state.data.candidates}
    made = []
    for key in keys:
        effect = found[key].options[0].effect
        assert effect is not None
        made.append(AcceptedEffect(found[key], effect))
    return tuple(made)


def test_a_payload_takes_the_place_of_three_links(loaded: Hypothesis) -> None:
    state = settled_hypothesis(loaded.problem, accepted(loaded, PATCHWORK))
    found = find_replacement(state)
    assert found is not None
    assert found.accepted[-1].candidate.name == "payload"
    assert len(found.replaces) >= 2
    assert not {a.candidate.key for a in found.replaces} & {a.candidate.key for a in found.accepted}
    assert (
        find_replacement(state, kept=[replace(one) for one in state.accepted]) is None
    )  # what stays is known by its place


@pytest.mark.parametrize("names", [("payload", "link_inertia"), ("link_inertia", "payload")])
def test_the_mass_that_two_effects_can_carry_is_the_first_one_s(loaded: Hypothesis, names: tuple[str, str]) -> None:
    state = settled_hypothesis(
        loaded.problem, accepted(loaded, tuple((n, () if n == "payload" else (4,)) for n in names))
    )
    mass = [values[0] for values in state.effect_values]
    assert mass[0] == pytest.approx(0.8, rel=0.1)
    assert mass[1] == pytest.approx(0.0, abs=0.05)
    error = np.sqrt(np.diag(uncertainty_of(state).theta.covariance))
    places = [p[0] for p in state.extension.places]
    assert abs(mass[0] - 0.8) < 4 * error[places[0]] < 0.2
    told = sum(
        state.columns(a.candidate, a.effect).torque(x) for a, x in zip(state.accepted, state.effect_values, strict=True)
    )
    fitted = state.baseline.torque(np.append(np.zeros(len(state.problem.freedom.prior)), state.fit.x[-20:]))
    np.testing.assert_allclose(told, fitted, atol=1e-5 * np.abs(fitted).max())


def test_of_a_warm_arm_and_the_friction_of_its_joints_the_warmth_is_kept(
    ur5: pid.Robot, healthy_runs: list[pid.Recording]
) -> None:
    """Each is redundant beside the others; what one number of the whole arm tells stays, whichever was found first."""
    v, friction = healthy_runs[2].dq, Arm().friction
    assert v is not None
    less = -0.1 * (friction.coulomb * np.tanh(v / 0.01) + friction.viscous * v)
    state = opened(ur5, healthy_runs[:3], less)
    laws = [(name, (joint,)) for joint in range(1, 7) for name in ("coulomb_friction", "viscous_friction")]
    every = accepted(state, (("friction_level", ()), *laws))
    last = score_candidates(settled_hypothesis(state.problem, every))
    for some in (every, every[::-1]):
        kept = forward_search.without_redundant(state.problem, some, last)
        assert [one.candidate.name for one in kept] == ["friction_level"]


def test_effects_that_are_there_are_replaced_by_none(rubbing: Hypothesis) -> None:
    true = (("coulomb_friction", (3,)), ("viscous_friction", (3,)))
    assert find_replacement(settled_hypothesis(rubbing.problem, accepted(rubbing, true))) is None


def test_what_was_replaced_is_not_searched_again(loaded: Hypothesis) -> None:
    barred = replace(loaded.problem, barred=frozenset({PATCHWORK[0]}))
    state = state_hypothesis(barred, (), loaded.model)
    assert PATCHWORK[0] not in {c.key for c in state.data.candidates}
    assert PATCHWORK[1] in {c.key for c in state.data.candidates}


def test_a_search_that_finds_more_than_a_handful_stops(rubbing: Hypothesis, monkeypatch: pytest.MonkeyPatch) -> None:
    assert not search_effects(rubbing.problem).overfull
    monkeypatch.setattr(forward_search, "HANDFUL", 1)
    found = search_effects(rubbing.problem)
    assert found.overfull
    assert len(found.accepted) == 2


def test_a_stopped_search_completes_the_joints_of_what_it_found(
    ur5: pid.Robot, healthy_runs: list[pid.Recording], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Which joints came before the last finding is chance: dry friction of joints 2, 3 and 5 is one finding, and a spring a second one."""
    one = healthy_runs[2]
    assert one.dq is not None
    more = np.tanh(one.dq / 0.02) * [0.0, 3.0, 2.0, 0.0, 1.0, 0.0]
    more[:, 0] = one.q[:, 0]
    state = opened(ur5, healthy_runs[:3], more)
    rubbing = {("coulomb_friction", (joint,)) for joint in (2, 3, 5)}
    spring = ("joint_spring", (1,))
    assert {a.candidate.key for a in search_effects(state.problem).accepted} == {*rubbing, spring}
    monkeypatch.setattr(forward_search, "HANDFUL", 0)
    found = search_effects(state.problem)
    assert found.overfull
    assert {a.candidate.key for a in found.accepted} == rubbing


def test_a_stopped_search_has_one_cause_and_says_what_to_do() -> None:
    given = [finding("payload", "cause"), finding("coulomb_friction", "cause"), finding("joint_spring", "hint")]
    contact = replace(finding("contact", "cause"), intervals=((1.0, 2.0),))
    answer = single_cause([*given, contact])
    assert [f.grade for f in answer] == ["cause", "contribution", "hint", "cause"]
    assert ["one of more than a handful" in f.no_cause for f in answer] == [False, True, False, False]
    assert [f.grade for f in single_cause(given[1:])] == ["cause", "hint"]
    ordinary = single_cause(
        [*given[::-1], contact], ordinary={"coulomb_friction"}
    )  # friction that the model lacks, as any arm has it
    assert [f.grade for f in ordinary] == ["hint", "cause", "cause", "cause"]
    same, near = (
        replace(given[0], effect="presliding_hysteresis", rivals=(rival,))
        for rival in (
            Rival(effect="coulomb_friction", joints=(), inseparable=True),
            Rival(effect="coulomb_friction", joints=()),
        )
    )
    for law, grades in ((same, ["cause", "cause"]), (near, ["cause", "contribution"])):
        # friction by another law of the same torque on any motion leaves the one cause to what any arm does not have
        assert [f.grade for f in single_cause([law, given[0]], ordinary={"coulomb_friction"})] == grades
    sentence = wrong_baseline_sentence("different", (1, 2, 5), answer[:1])
    for part in ("joints 1 and 2 and 5", "joints 1, 2 and 5"):
        if part in sentence:
            break
    else:
        pytest.fail(sentence)
    assert "what is missing" in sentence
    assert sentence.endswith("the best single cause is payload.")
    assert "what is missing" not in wrong_baseline_sentence("missing", (1,), answer[:1])
    confirmed = wrong_baseline_sentence("missing", (1,), answer[:1], confirmed=True)
    assert "holds on the holdout, so ask of that one" in confirmed


def warming(seed: int) -> pid.Recording:
    """Two joints: the first one's friction builds up over a distance, the second one's falls by half while it warms up."""
    one = recorded(seed, LEVEL)
    assert one.dq is not None
    more = 2.0 * np.exp(-one.time / 10) * one.dq[:, 1]
    return replace(one, effort=one.effort + np.column_stack([0 * more, more]))


def test_a_model_is_not_extended_by_a_patchwork(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where more than a handful was found, one here, it carries the best single cause, and its errors are those of this model."""
    (tmp_path / "two.urdf").write_text(urdf(ARMS["two"]))
    runs = [warming(seed) for seed in (41, 42)]
    estimate = pid.identify(pid.load_robot(tmp_path / "two.urdf"), runs)
    plain = pid.diagnose_motion(estimate, runs)
    for module in (forward_search, learn):
        monkeypatch.setattr(module, "HANDFUL", 1)
    searched_once(monkeypatch)
    stopped = pid.diagnose_motion(estimate, runs)
    (cause,) = stopped.causes
    assert len(stopped.findings) > 1
    assert stopped.extended is not None
    assert {e.name for e in stopped.extended.effects} - {e.name for e in estimate.model.effects} == {cause.effect}
    others = [j for j in range(2) if j + 1 not in cause.joints]
    assert others
    assert (stopped.after.rms[others] > 0.99 * stopped.before.rms[others]).all()
    assert (plain.after.rms < 0.9 * plain.before.rms).any()
    assert "alone the extended model carries" in " ".join(str(stopped).split())
    confirmed = pid.diagnose_motion(estimate, runs, warming(43))
    assert confirmed.extended is not None
    carried = {e.name for e in confirmed.extended.effects}
    assert {f.effect for f in confirmed.findings if f.grade != "hint"} <= carried
    assert len(carried - {e.name for e in estimate.model.effects}) > 1
    assert "alone" not in str(confirmed)


def bending(seed: int) -> pid.Recording:
    """Twenty seconds of two joints, by pinocchio, whose friction grows with the square of the speed."""
    rng, time = np.random.default_rng(seed), np.arange(0.0, 20.0, 0.004)
    q, v, tau = swung(rng, time)
    tau += np.array([2.0, 6.0]) * v * np.abs(v) + 0.05 * rng.standard_normal(tau.shape)
    return pid.Recording.from_arrays(time, q, dq=v, effort=tau, source=str(seed))


def test_a_joint_that_was_found_beside_what_is_not_carried_is_a_hint(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Friction bends on both joints, most on the second; that of the first is taken for one that does not meet the conditions beside it alone."""
    (tmp_path / "two.urdf").write_text(urdf(ARMS["two"]))
    runs = [bending(seed) for seed in (41, 42)]
    estimate = pid.identify(pid.load_robot(tmp_path / "two.urdf"), runs)
    monkeypatch.setattr(
        searched, "search_and_learn", lambda problem, progress: replace(search_effects(problem), overfull=True)
    )
    monkeypatch.setattr(judged, "without_redundant", lambda problem, accepted, last: accepted[:1])
    stopped = pid.diagnose_motion(estimate, runs)
    (cause,) = stopped.causes
    (lost,) = [f for f in stopped.findings if f.effect == cause.effect and f is not cause]
    assert (cause.joints, lost.joints) == ((2,), (1,))
    assert (lost.grade, lost.doubts) == ("hint", (BESIDE_OTHERS,))
    assert stopped.extended is not None
    (carried,) = [e for e in stopped.extended.effects if e.name == cause.effect]
    assert carried.joints == (2,)


def test_changes_that_a_control_set_apart_are_no_patchwork() -> None:
    """Seven effects were found, five of which the arm had before: two faults remain, and both may be causes."""
    two = [finding("payload", "cause"), finding("coulomb_friction", "cause")]
    assert is_patchwork(overfull=True, controlled=False, compared=False, findings=two)
    assert not is_patchwork(overfull=True, controlled=True, compared=False, findings=two)
    assert is_patchwork(overfull=True, controlled=True, compared=False, findings=[*two, *two, *two])
    assert not is_patchwork(overfull=True, controlled=True, compared=True, findings=[*two, *two, *two])
    assert not is_patchwork(overfull=False, controlled=False, compared=False, findings=[*two, *two, *two])


def test_new_surrogates_are_spared_only_where_they_could_change_nothing(rubbing: Hypothesis) -> None:
    scores = score_candidates(rubbing)
    index = choose_candidate(scores)
    assert index is not None
    evidence = float(scores.evidence_without_best_fold[index])
    assert is_beyond_doubt(replace(scores, threshold=0.9 * evidence / DOUBT))
    assert not is_beyond_doubt(replace(scores, threshold=1.1 * evidence / DOUBT))
    sure = replace(scores, threshold=0.9 * evidence / DOUBT, contact_threshold=5.0)
    pushed = replace(
        scores.contact,
        evidence=np.array([10.0]),
        evidence_without_best_joint=np.array([1.0]),
        reduction=10.0,
        joint_reduction=10.0,
    )
    assert not is_beyond_doubt(replace(sure, contact=pushed))
    assert is_beyond_doubt(replace(sure, contact=pushed, contact_threshold=20.0))
    assert not is_beyond_doubt(replace(sure, contact=pushed, contact_threshold=np.inf))  # it was never drawn
    assert is_beyond_doubt(replace(sure, contact=replace(pushed, joint_reduction=1.0), contact_threshold=np.inf))


def test_sources_of_a_load_are_read(tmp_path: Path) -> None:
    """The plant's load is what it says: 0.8 kg more on the last link."""
    more = hide(exact_arm(), "payload", (), 0.8).links - exact_arm().links
    assert more[-1, 0] == pytest.approx(0.8)
    assert not more[:-1].any()


def finding(effect: str, grade: Grade) -> Finding:
    gain = Reduction(rms_before=1.0, rms_after=0.5, reduction_percent=50.0, interval95=(40.0, 60.0))
    return Finding(
        effect=effect,
        joints=(),
        parameters=(),
        gain=gain,
        rivals=(),
        intervals=(),
        advice="",
        evidence=1.0,
        grade=grade,
    )


def test_nothing_is_accepted_after_a_placebo(rubbing: Hypothesis) -> None:
    """Where what cannot be a cause explains most, what explains less proves nothing."""
    scores = score_candidates(rubbing)
    assert choose_candidate(scores) is not None
    placebo = next(k for k, c in enumerate(scores.hypothesis.data.candidates) if c.placebo)
    at = np.arange(len(scores.gain)) == placebo
    better = replace(
        scores,
        gain=np.where(at, 2 * scores.gain.max(), scores.gain),
        evidence_without_best_fold=np.where(at, 2 * scores.threshold, scores.evidence_without_best_fold),
        visible_share=np.where(at, 1.0, scores.visible_share),
    )
    assert choose_candidate(better) is None
