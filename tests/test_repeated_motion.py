"""A motion that is recorded again: what the model lacks cancels, and what has changed is left, alone and exact."""

from __future__ import annotations

import re
import warnings
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.repeated.comparison import compare_with_control
from physident.diagnosis.repeated.sureness import as_sure_as
from physident.diagnosis.result.saved import read_diagnosis
from physident.estimation.identify import prepare_all
from physident.estimation.results.fitted import fitted_recordings
from tests.bags import write_bag
from tests.plant import Arm, Contact, Sensors, hide, multisine, record

pytestmark = pytest.mark.slow

MOTIONS = (71, 73, 75)
CHANGE = ("viscous_friction", 3, 2.5)  # N m s a rad: an eighth of the torque of joint 3


def faulty() -> Arm:
    """An arm with cables, cogging and friction that slips: nothing of it is in a default model."""
    arm = Arm()
    for joint, stiffness, ripple in ((1, 6.0, 4.0), (2, 9.0, 5.0), (3, 5.0, 3.0), (4, 0.8, 0.6)):
        arm = hide(arm, "joint_spring", joint, stiffness)
        arm = hide(arm, "torque_ripple", joint, ripple, order=3)
    return hide(arm, "presliding_hysteresis", 2, 4.0 / 0.004, slip=0.004)


def taken(folder: Path, name: str, arm: Arm, motion: int, noise: int, duration: float = 20.0) -> pid.Recording:
    record(arm, multisine(motion, duration=duration), Sensors(), noise, step=4e-3).write_csv(folder / f"{name}.csv")
    return pid.load_recording(folder / f"{name}.csv")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("repeated")


@pytest.fixture(scope="module")
def model(ur5: pid.Robot, folder: Path) -> pid.Estimate:
    runs = [taken(folder, f"before{seed}", faulty(), seed, seed) for seed in MOTIONS]
    estimate = pid.identify(ur5, runs)
    estimate.save(folder / "model.json")
    return pid.load_estimate(folder / "model.json")


@pytest.fixture(scope="module")
def again(folder: Path) -> list[pid.Recording]:
    """The same motions of the arm after it has changed, with other noise."""
    name, joint, size = CHANGE
    arm = hide(faulty(), name, joint, size)
    return [taken(folder, f"after{seed}", arm, seed, 500 + seed) for seed in MOTIONS[:2]]


@pytest.fixture(scope="module")
def found(model: pid.Estimate, again: list[pid.Recording]) -> pid.Diagnosis:
    return pid.diagnose_motion(model, again)


def test_what_has_changed_is_named_alone_with_its_value(found: pid.Diagnosis) -> None:
    (cause,) = found.causes
    name, joint, size = CHANGE
    assert (cause.effect, cause.joints, cause.rivals) == (name, (joint,), ())
    assert cause.parameters[0].change == pytest.approx(size, rel=0.03)
    assert [Path(str(used.repeats)).stem for used in found.recordings] == ["before71", "before73"]
    assert "compared: 2 of 2 recordings repeat a motion" in " ".join(repr(found).split())


@pytest.mark.usefixtures("model")  # it writes the file
def test_what_a_model_always_lacked_is_searched_once(again: list[pid.Recording], folder: Path) -> None:
    """Who holds recording after recording against a model waits for that search once, and gets the same answers."""
    loaded, said = pid.load_estimate(folder / "model.json"), list[str]()
    first, second = (pid.diagnose_motion(loaded, again[:1], progress=said.append) for _ in range(2))
    assert [text for text in said if "own recordings" in text] == [
        "searching the model's own recordings for what they show already",
        "the model's own recordings were searched before",
    ]
    assert first.missing_since_before
    assert second.missing_since_before == first.missing_since_before
    assert second.findings == first.findings


def test_nothing_is_named_where_nothing_has_changed(model: pid.Estimate, folder: Path) -> None:
    untouched = [taken(folder, f"same{seed}", faulty(), seed, 900 + seed) for seed in MOTIONS[:2]]
    found = pid.diagnose_motion(model, untouched)
    assert not found.findings
    # what is left is the noise of both recordings, a small part of what the model lacks
    assert max(one.rms for one in found.unexplained) < 0.2 * found.before.rms.max()


def test_the_errors_told_are_those_of_the_models_and_not_of_the_comparison(
    model: pid.Estimate, again: list[pid.Recording], found: pid.Diagnosis
) -> None:
    measured = pid.validate(model, again)
    np.testing.assert_allclose(found.before.rms, measured.rms, rtol=0.05)
    assert found.estimate is not None
    np.testing.assert_allclose(found.after.rms, pid.validate(found.estimate, again, include_fitted=True).rms, rtol=0.05)


def test_what_the_model_always_lacked_is_part_of_the_extended_model(
    model: pid.Estimate, again: list[pid.Recording], folder: Path, found: pid.Diagnosis
) -> None:
    """The change alone would leave what was wrong before; both together predict a motion that nothing saw."""
    assert found.extended is not None
    assert found.estimate is not None
    assert {old.effect for old in found.missing_since_before} <= {e.name for e in found.extended.effects}
    name, joint, size = CHANGE
    other = taken(folder, "unseen", hide(faulty(), name, joint, size), 98, 98)
    before, after = (pid.validate(one, [other]).rms for one in (model, found.estimate))
    assert after[joint - 1] < 0.6 * before[joint - 1]
    assert np.mean(after / before) < 0.8


def test_clocks_rates_and_ends_may_differ(model: pid.Estimate, again: list[pid.Recording]) -> None:
    """The second recording began a second later, lasts less long, and was written at another rate by another clock."""
    late = again[0]
    rows = slice(int(1.0 / np.median(np.diff(late.time))), int(0.95 * len(late.time)))
    cut = replace(late, time=late.time[rows] + 1e6, q=late.q[rows], dq=None, effort=late.effort[rows])
    robot, filter = model.model.robot, model.filter
    slower = pid.Filter(filter.cutoff, 100.0)
    control = prepare_all(robot, [pid.load_recording(source.path) for source in model.sources], filter)
    whole, part = prepare_all(robot, again[:1], filter), prepare_all(robot, [cut], slower)
    first, second = (compare_with_control(model.model, one, control) for one in (whole, part))
    assert first.partner == second.partner == (0,)
    off = [one.untouched[0].torque - one.signals[0].torque for one in (first, second)]  # type: ignore[operator]
    at = second.signals[0].time - 1e6
    same = np.array([np.interp(at, first.signals[0].time, column) for column in off[0].T]).T
    assert np.sqrt(np.mean((off[1] - same) ** 2)) < 0.1 * np.sqrt(np.mean(same**2))


def test_another_motion_is_not_compared_and_its_errors_do_not_hide_the_change(
    model: pid.Estimate, again: list[pid.Recording], folder: Path, found: pid.Diagnosis
) -> None:
    name, joint, size = CHANGE
    other = taken(folder, "other", hide(faulty(), name, joint, size), 99, 99)
    mixed = pid.diagnose_motion(model, [*again, other])
    assert [used.repeats is None for used in mixed.recordings] == [False, False, True]
    assert (mixed.causes[0].effect, mixed.causes[0].joints) == (name, (joint,))
    assert mixed.causes[0].parameters[0].change == pytest.approx(size, rel=0.06)
    assert len(mixed.causes) == len(found.causes)


@pytest.fixture(scope="module")
def refuted(model: pid.Estimate, again: list[pid.Recording], folder: Path) -> pid.Diagnosis:
    """The arm was mended before the last recording: only a comparison can say that the change is not there."""
    return pid.diagnose_motion(model, again, [taken(folder, "mended", faulty(), MOTIONS[2], 703)])


def test_a_holdout_that_is_compared_can_refute_and_one_that_is_not_cannot(refuted: pid.Diagnosis) -> None:
    assert not refuted.causes
    assert "not confirmed on unseen data" in refuted.findings[0].doubts


def test_a_push_during_a_repeated_motion_is_a_contact(model: pid.Estimate, folder: Path) -> None:
    pushed = replace(faulty(), contacts=(Contact(8.0, 9.0, ((25.0, -15.0, 20.0),)),))
    found = pid.diagnose_motion(model, [taken(folder, "pushed", pushed, MOTIONS[0], 811)])
    (cause,) = found.causes
    assert cause.effect == "contact"
    ((start, end),) = cause.intervals
    assert abs(start - 8.0) < 0.2
    assert abs(end - 9.0) < 0.2
    told = re.search(r"The strongest push is ([\d.]+) N", cause.in_words)
    assert told is not None
    assert float(told[1]) == pytest.approx(np.linalg.norm([25.0, -15.0, 20.0]), rel=0.1)


def test_what_drifts_within_one_repeated_motion_is_no_curve_over_time(model: pid.Estimate, folder: Path) -> None:
    """Of one motion every error is a function of time; the old recording is of the same motion."""
    one = taken(folder, "one", faulty(), MOTIONS[0], 812)
    drift = np.outer(np.sin(2 * np.pi * one.time / one.time[-1]), np.array([0, 4.0, 0, 0, 0, 0]))
    found = pid.diagnose_motion(model, [replace(one, effort=one.effort + drift)])
    assert "learned_time" not in {f.effect for f in found.findings}


def test_other_rows_count_by_their_error_and_by_how_long_it_lasts() -> None:
    rng = np.random.default_rng(0)
    regressor = cast(Any, SimpleNamespace(segment=np.repeat([0, 1], 4000), kept_rate=20.0))
    others = np.repeat([False, True], 4000)[:, None]
    level, size = np.full(6, 0.1) * np.arange(1.0, 7.0), 0.5 * np.arange(1.0, 7.0)
    white = others * size * rng.standard_normal((8000, 6))
    np.testing.assert_allclose(as_sure_as(level, white, np.ones((8000, 6)), regressor), 0.2, rtol=0.15)
    slow = np.repeat(white[::4], 4, axis=0)  # four rows are worth one: half as sure
    np.testing.assert_allclose(as_sure_as(level, slow, np.ones((8000, 6)), regressor), 0.1, rtol=0.2)
    # rows that are surer than a comparison count as they are
    np.testing.assert_allclose(as_sure_as(100 * level, white, np.ones((8000, 6)), regressor), 1.0)


def test_motions_on_which_the_model_is_far_off_do_not_hide_what_a_comparison_shows(
    model: pid.Estimate, again: list[pid.Recording], folder: Path
) -> None:
    """Twice as far, the cables pull as no recording of the model has shown."""
    name, joint, size = CHANGE
    changed = hide(faulty(), name, joint, size)
    far = [taken(folder, f"far{seed}", changed, seed, seed) for seed in (91, 93)]
    mixed = pid.diagnose_motion(model, [*again, *far])
    assert (mixed.causes[0].effect, mixed.causes[0].joints) == (name, (joint,))
    assert mixed.causes[0].parameters[0].change == pytest.approx(size, rel=0.06)


def test_a_periodic_motion_is_compared_from_its_first_period(model: pid.Estimate, again: list[pid.Recording]) -> None:
    """A period later it is like itself, too; noise must not decide which of both is taken."""
    filter, robot = model.filter, model.model.robot
    one = again[0]
    time = np.arange(0.0, 20.0, 0.008)
    angle = 2 * np.pi * 0.1 * time[:, None] * np.array([1, 2, 3, 1, 2, 3]) + np.arange(6)
    q, dq = 0.5 * np.sin(angle), np.pi * 0.1 * np.cos(angle) * np.array([1, 2, 3, 1, 2, 3])
    made = []
    for seed in range(8):
        noise = 1e-4 * np.random.default_rng(seed).standard_normal(q.shape)
        made.append(replace(one, time=time, q=q + noise, dq=dq + noise, effort=np.sin(angle)))
    control, *new = prepare_all(robot, made, filter)
    found = compare_with_control(model.model, new, [control])
    assert found.partner == (0,) * len(new)
    np.testing.assert_allclose(found.lag, 0.0, atol=0.01)


def test_standstill_before_and_after_the_motion_is_cut_off(
    model: pid.Estimate, again: list[pid.Recording], folder: Path
) -> None:
    """A logger that ran for eight seconds more on either side has recorded the same motion."""
    one, step = again[0], 0.008
    assert one.dq is not None
    wait = np.arange(1, 1001)[:, None] * np.ones(6)
    still = replace(
        one,
        time=one.time[0] + np.arange(len(one.time) + 2000) * step,
        q=np.concatenate([one.q[0] + 0 * wait, one.q, one.q[-1] + 0 * wait]),
        dq=np.concatenate([0 * wait, one.dq, 0 * wait]),
        effort=np.concatenate([one.effort[0] + 0 * wait, one.effort, one.effort[-1] + 0 * wait]),
    )
    control = prepare_all(model.model.robot, [pid.load_recording(s.path) for s in model.sources], model.filter)
    (padded,) = prepare_all(model.model.robot, [still], model.filter)
    assert compare_with_control(model.model, [padded], control).partner == (0,)


def test_a_bag_is_a_control_too(model: pid.Estimate, folder: Path, ur5: pid.Robot) -> None:
    """A bag is a folder, and its joints may be in another order than the arm's."""
    bag = write_bag(
        folder / "bag", pid.load_recording(model.sources[0].path), ur5.joint_names, order=(2, 0, 1, 5, 4, 3)
    )
    fitted = pid.identify(ur5, [pid.load_recording(bag, joints=ur5.joint_names)])
    (control,) = fitted_recordings(replace(fitted, fitted=()))
    np.testing.assert_allclose(control.q, pid.load_recording(model.sources[0].path).q, atol=1e-9)


def test_what_is_diagnosed_is_not_from_before(model: pid.Estimate, again: list[pid.Recording]) -> None:
    with pytest.raises(pid.InputError, match="diagnosed, and given as from before the change"):
        pid.diagnose_motion(model, again[:1], before=again[:1])


def test_recordings_from_before_are_named_as_such(
    model: pid.Estimate, again: list[pid.Recording], folder: Path
) -> None:
    """Held against the changed arm itself, nothing has changed, though the model is off."""
    later = taken(folder, "later", hide(faulty(), *CHANGE), MOTIONS[0], 901)
    found = pid.diagnose_motion(model, [later], before=again[:1])
    assert not found.causes
    text = " ".join(repr(found).split())
    assert "different from the recordings from before" in text
    assert "recordings repeat a motion from before" in text
    assert "fitted to" not in text


def test_a_verdict_does_not_call_noise_what_a_hint_explained(refuted: pid.Diagnosis) -> None:
    assert not refuted.causes
    left = refuted.unexplained[CHANGE[1] - 1]
    assert left.rms > 0.5 * CHANGE[2] * 0.2
    assert left.structured or left.may_hide_a_change
    assert "nothing has changed" not in str(refuted)


def test_recordings_with_gaps_are_compared_with_none(model: pid.Estimate, again: list[pid.Recording]) -> None:
    control = prepare_all(model.model.robot, [pid.load_recording(s.path) for s in model.sources], model.filter)
    (whole,) = prepare_all(model.model.robot, again[:1], model.filter)
    half = len(whole.time) // 2
    gapped = replace(whole, starts=(0, half))
    assert compare_with_control(model.model, [gapped], control).partner == (None,)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert compare_with_control(model.model, [whole], []).partner == (None,)


def test_a_model_that_errs_more_than_before_is_not_handed_on(ur5: pid.Robot, folder: Path) -> None:
    """Recordings with a load are given as those from before, to a model of the arm without one: the change is a hint, and no model."""
    loaded = hide(Arm(), "payload", (), 3.0)
    runs = [taken(folder, f"light{seed}", Arm(), seed, seed, 10.0) for seed in MOTIONS]
    before = [taken(folder, f"heavy{seed}", loaded, seed, 700 + seed, 10.0) for seed in MOTIONS[:2]]
    light = [taken(folder, f"light_again{seed}", Arm(), seed, 800 + seed, 10.0) for seed in MOTIONS[:2]]
    estimate = pid.identify(ur5, runs)
    with pytest.warns(pid.PhysidentWarning, match="not handed on"):
        found = pid.diagnose_motion(estimate, light, before=before)
    assert {(f.effect, f.grade) for f in found.findings} >= {("payload", "hint")}
    assert found.causes == ()
    assert found.extended is None
    found.save(folder / "refuted.json")
    assert "not handed on" in read_diagnosis(folder / "refuted.json").warnings[-1]
    assert found.estimate is None
    assert any("is not handed on" in text for text in found.warnings)
    with warnings.catch_warnings(action="ignore", category=pid.PhysidentWarning):
        right = pid.diagnose_motion(estimate, before, before=light)
    assert right.extended is not None
    assert (right.after.rms < right.before.rms).any()
