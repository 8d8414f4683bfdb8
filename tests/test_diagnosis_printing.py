"""A diagnosis as text: what could not be known is said, with its reason, and all of it fits a screen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.remainder.beside_own import beside_own
from physident.diagnosis.remainder.own_error import OwnError
from physident.diagnosis.remainder.unexplained import Unexplained, above_noise_floor, large_as_usual
from physident.diagnosis.result.findings import (
    Finding,
    JointErrors,
    ParameterValue,
    Reduction,
    Rival,
    Unseen,
    UsedRecording,
    Verdict,
)
from physident.diagnosis.result.text import WIDTH

SILENT, INSIDE = "shows no torque", "inside what the baseline may take up"


@pytest.fixture(scope="module")
def diagnosis(ur5: pid.Robot) -> pid.Diagnosis:
    """Nothing found, and of every effect some joints that could not be told, for either reason."""
    levels = JointErrors(np.ones(6), np.full(6, 10.0))
    unseen = [Unseen(name, (j,), (SILENT, INSIDE)[j % 2]) for name in pid.CATALOGUE for j in range(1, 7)]
    return pid.Diagnosis(
        question="missing", verdict="nothing_missing", findings=(), before=levels, after=levels, scored_on="left-out rows",
        noise_floor=None, placebos=(), unseen=tuple(unseen), unexplained=(), recordings=(), model=pid.Model.nominal(ur5),
        extended=None, estimate=None, filter=pid.Filter(), layout=None, drive_gains=None, unidentified=(), seed=0,
        incomplete=(), recording_offsets=False,
    )  # fmt: skip


def sentences(diagnosis: pid.Diagnosis) -> list[str]:
    """The printed rows, each with what it was wrapped into."""
    return repr(diagnosis).replace("\n     ", " ").splitlines()


def test_effects_that_cannot_be_told_stand_with_their_reason(diagnosis: pid.Diagnosis) -> None:
    told = [row for row in sentences(diagnosis) if row.startswith("neither confirmed nor ruled out")]
    assert len(told) == 2
    for reason, joints in ((SILENT, "2,4,6"), (INSIDE, "1,3,5")):
        (row,) = [row for row in told if reason in row]
        listed = row.partition(": ")[2].split("; ")
        assert listed == [f"{name} {joints}" for name in pid.CATALOGUE]
    lines = repr(diagnosis).splitlines()
    assert len(lines) < 50
    assert max(map(len, lines)) <= WIDTH


def test_no_reason_is_given_where_everything_could_be_told(diagnosis: pid.Diagnosis) -> None:
    assert "neither confirmed" not in repr(replace(diagnosis, unseen=()))


def test_a_noise_floor_that_nothing_measured_is_not_passed_over(diagnosis: pid.Diagnosis) -> None:
    (row,) = [row for row in sentences(diagnosis) if row.strip().startswith("noise floor")]
    assert row.strip() == "noise floor: not known, because no motion was repeated"
    (row,) = [
        row
        for row in sentences(replace(diagnosis, noise_floor=np.arange(1.0, 7.0)))
        if row.strip().startswith("noise floor")
    ]
    assert [float(x) for x in row.split("]")[1].split()] == [1, 2, 3, 4, 5, 6]


def test_what_lies_within_the_noise_floor_is_not_called_structure(diagnosis: pid.Diagnosis) -> None:
    slow = Unexplained(
        joint=1, rms=1.0, lag_one=0.9, memory=2.0, white_memory=0.1, slow=0.5, peak=0.1, velocity=0.0, position=0.0,
        load=0.0, time=0.0, order=1.0, order_share=0.0,
    )  # fmt: skip
    assert slow.structured
    within = replace(diagnosis, unexplained=(slow,), noise_floor=np.ones(6))
    assert within.structured == ()
    assert "unexplained structure" not in repr(within)
    above = replace(within, noise_floor=np.full(6, 0.5))
    assert above.structured == (slow,)
    assert "unexplained structure in the residual" in repr(above)


def test_an_error_on_unseen_recordings_that_no_noise_makes_is_told(diagnosis: pid.Diagnosis) -> None:
    """A residual that is noise where it was fitted says nothing of what the arm does elsewhere."""
    assert "on the holdout" not in repr(diagnosis)
    unseen = replace(diagnosis, scored_on="holdout", wrong_unseen=(2, 4))
    assert any(row.startswith("on the holdout joints 2 and 4 err more than twice") for row in sentences(unseen))


def test_warnings_stand_before_the_answer(diagnosis: pid.Diagnosis) -> None:
    rows = sentences(replace(diagnosis, warnings=("the description is of another robot than the recording",)))
    assert rows[0] == "warning: the description is of another robot than the recording"
    assert rows[1].startswith("what is missing from the model:")
    assert "put that right" not in " ".join(rows)  # where no cause is named, nothing can stand for it


def test_a_verdict_does_not_praise_causes_of_a_wrong_set_up(diagnosis: pid.Diagnosis) -> None:
    """Joints in another order look like a scale of all torque and cross-talk, which leave nothing but noise."""
    gain = Reduction(rms_before=2.0, rms_after=1.0, reduction_percent=50.0, interval95=(40.0, 60.0))
    found = Finding(
        effect="torque_scale", joints=(), parameters=(), gain=gain, rivals=(), intervals=(), advice="", evidence=9.0,
        takes_percent=75.0, leaves_percent=0.0,
    )  # fmt: skip
    explained = replace(diagnosis, findings=(found,), verdict="explained")
    swapped = replace(explained, warnings=("the efforts of joints 1 and 2 are swapped",))
    (verdict,) = (row for row in sentences(swapped) if row.startswith("verdict:"))
    assert verdict.endswith("but a cause may stand for what the warning says, so put that right first")
    assert "put that right" not in " ".join(sentences(explained))


FAINT: dict[str, Any] = dict.fromkeys(("slow", "peak", "velocity", "position", "load", "time", "order_share"), 0.0)


def remainder(joint: int, memory: float = 2.0, rms: float = 1.0) -> Unexplained:
    """What is left of a joint, whose noise would remember for a tenth of a second."""
    return Unexplained(joint=joint, rms=rms, lag_one=0.9, memory=memory, white_memory=0.1, order=1.0, **FAINT)


def told(diagnosis: pid.Diagnosis, verdict: Verdict, unexplained: Sequence[Unexplained]) -> str:
    """The printed text of a question what has changed."""
    changed = replace(diagnosis, question="different", verdict=verdict, unexplained=tuple(unexplained))
    return " ".join(repr(changed).split())


def test_a_joint_that_errs_more_than_on_the_model_s_own_recordings_is_named(diagnosis: pid.Diagnosis) -> None:
    beside = beside_own(
        [remainder(1), remainder(2)],
        OwnError(rms=np.array([0.2, 0.5]), times=None, period=0.01),
        np.ones((4, 2)),
        0.0,
        1.0,
    )
    assert [one.grown for one in beside] == [True, False]  # five times as much, and twice
    text = told(diagnosis, "unexplained", beside)
    assert "prove; but joint 1 errs 5 times as much as on the model's own recordings" in text
    assert "joint 2 errs" not in text
    assert "times what the model leaves" not in text
    larger = beside_own(
        [remainder(1), remainder(2)],
        OwnError(rms=np.array([0.6, 0.4]), times=None, period=0.01),
        np.ones((4, 2)),
        0.0,
        1.0,
    )
    assert "unseen data. It is 1.7 to 2.5 times what the model leaves" in told(diagnosis, "unexplained", larger)


def test_a_joint_that_errs_as_on_the_model_s_own_recordings_has_not_changed(diagnosis: pid.Diagnosis) -> None:
    """However long its residual remembers: an incomplete model's does so on any recording."""
    beside = beside_own(
        [remainder(1), remainder(2)],
        OwnError(rms=np.array([1.0, 0.8]), times=None, period=0.01),
        np.ones((4, 2)),
        0.0,
        1.0,
    )
    assert not any(one.structured for one in beside)
    text = told(diagnosis, "nothing_missing", beside)
    assert "is as large as on the model's own recordings" in text
    assert "on joints 1 and 2 it is 1.0 to 1.2 times what the model leaves on its own recordings" in text
    assert "is noise" not in text


def test_where_the_model_errs_differently_on_its_own_recordings_a_change_may_hide(diagnosis: pid.Diagnosis) -> None:
    """As large as usual is proof only where what is usual is narrow."""
    for times, hides in (([1.4, 1.4], False), ([1.4, 8.0], True)):
        own = OwnError(rms=np.array([0.9, 0.8]), times=np.array(times), period=0.01)
        beside = beside_own([remainder(1), remainder(2)], own, np.ones((4, 2)), 0.0, 1.0)
        assert not any(one.structured for one in beside)
        text = told(diagnosis, "nothing_missing", beside)
        assert ("verdict: nothing has changed" in text) is not hides
        assert ("verdict: no change was found" in text) is hides
        assert ("On joint 2 a change may hide in it" in text) is hides


@pytest.mark.parametrize(
    ("lacks", "repeats", "outcome"),
    [
        (False, None, "nothing has changed"),
        (True, None, "no change was found"),
        (True, "old.csv", "nothing has changed"),
    ],
)
def test_what_the_model_always_lacked_may_hide_a_change_unless_it_was_taken_off(
    lacks: bool, repeats: str | None, outcome: str, diagnosis: pid.Diagnosis
) -> None:
    """What shows in both may be a change in disguise: viscous friction that has grown, taken for a channel that is late."""
    late = Finding(
        effect="torque_delay", joints=(2,), parameters=(), rivals=(), intervals=(), advice="", evidence=9.0,
        gain=Reduction(rms_before=1.0, rms_after=0.9, reduction_percent=10.0, interval95=(5.0, 15.0)), grade="cause",
    )  # fmt: skip
    asked = replace(diagnosis, recordings=(UsedRecording("new.csv", "", "diagnosed", repeats),), controlled=True)
    found = replace(asked, missing_since_before=(late,) if lacks else ())
    unnamed = replace(asked, incomplete=(2,) if lacks else ())
    for one in (found, unnamed):
        assert f"verdict: {outcome}" in told(one, "nothing_missing", [])


def test_what_differs_without_proof_is_not_said_to_have_been_missing(diagnosis: pid.Diagnosis) -> None:
    """Of what the model has, another value; of what it lacks, the value."""
    new = ParameterValue(
        name="stribeck_friction", joint=3, value=2.0, change=2.0, std=0.1, interval95=(1.8, 2.2), change_interval95=(1.8, 2.2),
        unit="N m",
    )  # fmt: skip
    lacked = Finding(
        effect="stribeck_friction", joints=(3,), parameters=(new,), rivals=(), intervals=(), advice="", evidence=9.0,
        gain=Reduction(rms_before=1.0, rms_after=0.9, reduction_percent=10.0, interval95=(5.0, 15.0)), grade="cause",
    )  # fmt: skip
    other = replace(lacked, parameters=(replace(new, change=0.4, change_interval95=(0.2, 0.6)),))
    rows = sentences(replace(diagnosis, missing_since_before=(other, lacked), controlled=True))
    heads = [row for row in rows if row.endswith("differ by as much:")]
    assert [head.split(",")[0] for head in heads] == ["missing since before", "different here"]
    assert "changed by" not in rows[rows.index(heads[0]) + 1]
    assert "changed by +0.4 N m [0.2, 0.6] to 2" in rows[rows.index(heads[1]) + 1]


@pytest.mark.parametrize(("fitted", "shown"), [(0.2, True), (0.8, False)])
def test_an_error_that_is_far_smaller_as_fitted_is_told_beside_it(
    diagnosis: pid.Diagnosis, fitted: float, shown: bool
) -> None:
    """The ends of a curve that one stretch alone has seen: that stretch left out, the curve is a guess."""
    left = tuple(remainder(j, rms=fitted if j == 1 else 0.9) for j in range(1, 7))
    given = replace(diagnosis, unexplained=left)
    table = [row for row in sentences(given) if row.strip().startswith("RMS as fitted")]
    assert bool(table) is shown
    if shown:
        assert [float(x) for x in table[0].split("]")[1].split()] == [0.2, 0.9, 0.9, 0.9, 0.9, 0.9]
    for other in (
        replace(given, scored_on="holdout"),
        replace(given, recordings=(UsedRecording("new.csv", "", "diagnosed", "old.csv"),)),
    ):
        assert "RMS as fitted" not in repr(other)


@pytest.mark.parametrize(("after", "says"), [(0.8, True), (0.6, False)])
def test_a_cause_that_is_not_most_of_a_joint_s_error_is_not_told_as_if_it_were(
    diagnosis: pid.Diagnosis, after: float, says: bool
) -> None:
    """Twelve newton metres of which ten stay: the headline names other joints, and the verdict this one."""
    rms = np.array([0.1, after, 0.1, 0.1, 0.1, 0.1])
    left = tuple(remainder(j, memory=2.0 if j == 2 else 0.05, rms=rms[j - 1]) for j in range(1, 7))
    given = replace(diagnosis, verdict="partly_explained", after=JointErrors(rms, 10 * rms), unexplained=left)
    assert ("What was found is not most of the error of joint 2" in " ".join(repr(given).split())) is says


def test_no_verdict_calls_an_error_small_that_is_only_usual(diagnosis: pid.Diagnosis) -> None:
    """A model that errs by 30 times as much elsewhere makes 20 times usual: that is not as large as on its own recordings."""
    own = OwnError(rms=np.array([0.05, 0.8]), times=np.array([30.0, 1.4]), period=0.01)
    beside = beside_own([remainder(1), remainder(2)], own, np.ones((4, 2)), 0.0, 1.0)
    assert [one.joint for one in large_as_usual(beside, None)] == [1]
    assert large_as_usual(beside, np.ones(2)) == ()
    outcomes: dict[Verdict, str] = {"nothing_missing": "no change was found", "partly_explained": "partly explained"}
    for verdict, outcome in outcomes.items():
        text = told(diagnosis, verdict, beside)
        assert f"verdict: {outcome}" in text
        assert "no larger than is usual for this model" in text
        assert "20.0 times what the model leaves on its own recordings, and up to 30.0 times is usual" in text
        assert "as large as on the model's own recordings" not in text


def test_a_joint_that_errs_more_has_changed_however_short_its_residual_remembers() -> None:
    """As play in a gear shows: at reversals, for some hundredths of a second each, and noise is as large on any motion."""
    (noise,) = beside_own(
        [remainder(1, memory=0.1)], OwnError(rms=np.array([1.0]), times=None, period=0.01), np.ones((4, 1)), 0.0, 1.0
    )
    (play,) = beside_own(
        [remainder(1, memory=0.1)], OwnError(rms=np.array([0.3]), times=None, period=0.01), np.ones((4, 1)), 0.0, 1.0
    )
    assert (noise.structured, play.structured, play.grown) == (False, True, True)


def test_what_is_usual_is_told_where_recordings_say_it(diagnosis: pid.Diagnosis) -> None:
    own = OwnError(rms=np.array([0.7, 0.8]), times=np.array([1.3, 1.3]), period=0.01)
    beside = beside_own([remainder(1, memory=0.1), remainder(2)], own, np.ones((4, 2)), 0.0, 1.0)
    assert [one.structured for one in beside] == [True, False]  # 1.43 and 1.25 times
    text = told(diagnosis, "unexplained", beside)
    assert "It is 1.4 times what the model leaves on its own recordings, and up to 1.3 times is usual" in text
    assert "joint 1: RMS 1 N m (1.4 times that of the model's own recordings)" in text


@pytest.mark.parametrize(("errs", "told_so"), [(8.0, True), (2.9, False)])
def test_what_is_no_proven_change_hides_no_error(diagnosis: pid.Diagnosis, errs: float, told_so: bool) -> None:
    """A value that is fitted to these recordings, and is no proven change, takes all of it up; the model of before errs all the same."""
    own = OwnError(rms=np.array([0.9, 1.0]), times=np.array([2.0, 2.0]), period=0.01)
    left = [remainder(1, memory=0.1), remainder(2, memory=0.1)]
    beside = beside_own(left, own, np.ones((4, 2)), 0.0, 1.0, {1: 0.9 * errs, 2: 1.0})
    assert [(one.structured, one.grown) for one in beside] == [(told_so, told_so), (False, False)]
    text = told(diagnosis, "unexplained" if told_so else "nothing_missing", beside)
    assert ("joint 1 errs 8 times as much as on the model's own recordings" in text) is told_so
    assert ("what takes that up here is no proven change" in text) is told_so


def test_recordings_of_one_joint_each_do_not_say_what_is_usual(diagnosis: pid.Diagnosis) -> None:
    own = OwnError(rms=np.array([0.05, 0.8]), times=np.array([1.6e6, 1.4]), period=0.01)
    text = told(diagnosis, "nothing_missing", beside_own([remainder(1), remainder(2)], own, np.ones((4, 2)), 0.0, 1.0))
    assert "how much is usual these do not tell, for each of them shows what the others do not" in text
    assert "times is usual" not in text


def test_a_difference_of_two_recordings_errs_as_both() -> None:
    rng = np.random.default_rng(3)
    own = 0.3 * rng.standard_normal((2, 4000))
    left = remainder(1, rms=float(np.std(own[1] - own[0])))
    (beside,) = beside_own([left], OwnError(rms=np.array([0.3]), times=None, period=0.01), np.ones((4, 1)), 1.0, 1.0)
    assert beside.times_own == pytest.approx(1.0, abs=0.05)


def test_what_a_model_errs_by_along_other_motions_is_not_usual_along_the_same() -> None:
    """Along a motion from before the errors of the model are taken off: a joint that is five times its own error has changed there."""
    own = OwnError(rms=np.array([0.2]), times=np.array([9.0]), period=0.01)
    other, partly, same = (beside_own([remainder(1)], own, np.ones((4, 1)), share, 1.0)[0] for share in (0.0, 0.5, 1.0))
    assert (other.grown, partly.grown, same.grown) == (False, False, True)
    assert same.usual_times is None


def test_what_an_exact_simulation_leaves_is_not_held_against_it() -> None:
    """Of recordings without noise the model leaves a billionth: beside what a sensor tells apart, that is nothing."""
    (beside,) = beside_own(
        [remainder(1, rms=1e-4)],
        OwnError(rms=np.array([1e-9]), times=None, period=0.01),
        np.full((4, 1), 10.0),
        0.0,
        1.0,
    )
    assert not beside.grown


def test_a_contribution_has_its_value_and_what_it_may_also_be(diagnosis: pid.Diagnosis) -> None:
    size = ParameterValue(
        name="torque_constant",
        joint=5,
        value=0.018,
        change=0.018,
        std=0.001,
        interval95=(0.016, 0.02),
        change_interval95=(0.016, 0.02),
        unit="1",
    )
    found = Finding(
        effect="torque_constant", joints=(5,), parameters=(size,), rivals=(Rival("viscous_friction", (5,)),), intervals=(),
        gain=Reduction(rms_before=1.0, rms_after=0.9, reduction_percent=10.0, interval95=(5.0, 15.0)), advice="",
        evidence=9.0, grade="contribution",
    )  # fmt: skip
    (row,) = [row for row in sentences(replace(diagnosis, findings=(found,))) if row.startswith("contribution")]
    assert "torque_constant (joint 5) or viscous_friction (joint 5): 0.018 [0.016, 0.02], 10.0 % less RMS" in row


@pytest.mark.parametrize(("low", "told"), [(1.15, True), (-0.3, False)])
def test_what_others_take_the_part_of_is_told_and_what_is_nothing_is_not(
    diagnosis: pid.Diagnosis, low: float, told: bool
) -> None:
    """The rotor of a joint, of which the link behind it takes the part, is there; a value that may be zero may not be."""
    size = ParameterValue(
        name="rotor_inertia", joint=1, value=1.18, change=1.18, std=0.02, interval95=(low, 1.22), change_interval95=(low, 1.22),
        unit="kg m^2",
    )  # fmt: skip
    found = Finding(
        effect="rotor_inertia", joints=(1,), parameters=(size,), rivals=(), intervals=(), advice="", evidence=0.0,
        gain=Reduction(rms_before=1.0, rms_after=1.0, reduction_percent=0.0, interval95=(0.0, 0.0)), grade="hint",
        doubts=("its sign changes between recordings",), takes_percent=0.0, leaves_percent=5.0,
    )  # fmt: skip
    rows = [row for row in sentences(replace(diagnosis, findings=(found,))) if row.startswith("hint")]
    assert len(rows) == told
    assert all("1.18 kg m^2 [1.15, 1.22]" in row and "without it others take its part" in row for row in rows)


@pytest.mark.parametrize(("reach", "says"), [(99.0, "0.013 rad [0.000131, 1.29]"), (101.0, "distance not known")])
def test_a_shape_of_which_not_even_the_order_of_magnitude_is_known_has_no_value(
    diagnosis: pid.Diagnosis, reach: float, says: str
) -> None:
    ends = (0.013 / reach, 0.013 * reach)
    shape = ParameterValue(
        name="distance", joint=5, value=0.013, change=0.013, std=0.1, interval95=ends, change_interval95=ends, unit="rad"
    )  # fmt: skip
    found = Finding(
        effect="presliding_hysteresis", joints=(5,), parameters=(shape,), rivals=(), intervals=(), advice="", evidence=9.0,
        gain=Reduction(rms_before=1.0, rms_after=0.9, reduction_percent=10.0, interval95=(5.0, 15.0)), grade="cause",
    )  # fmt: skip
    assert says in repr(replace(diagnosis, findings=(found,)))


@pytest.mark.parametrize(("count", "says"), [(1, "but not how large it is"), (2, "none of its single values is")])
def test_a_cause_whose_values_may_all_be_zero_says_what_that_means(
    diagnosis: pid.Diagnosis, count: int, says: str
) -> None:
    open_ones = tuple(
        ParameterValue(
            name=f"v{k}",
            joint=5,
            value=0.01,
            change=0.01,
            std=0.01,
            interval95=(-0.01, 0.03),
            change_interval95=(-0.01, 0.03),
            unit="1",
        )
        for k in range(count)
    )
    found = Finding(
        effect="joint_zero_offset", joints=(5,), parameters=open_ones, rivals=(), intervals=(), advice="", evidence=9.0,
        gain=Reduction(rms_before=1.0, rms_after=0.9, reduction_percent=10.0, interval95=(5.0, 15.0)), grade="cause",
    )  # fmt: skip
    assert f"the effect is significant, {says}: " in " ".join(repr(replace(diagnosis, findings=(found,))).split())


def test_noise_is_as_loud_as_the_rate_makes_it(ur5: pid.Robot) -> None:
    """The filter's own output of white noise, at two rates."""
    at = {}
    for rate in (125.0, 25.0):
        noise = np.random.default_rng(2).standard_normal((20_000, 6))
        time = np.arange(len(noise)) / rate
        signals = pid.Signals(time, noise, noise, noise, noise, rate=rate)
        at[rate] = signals, float(np.std(pid.Filter(5.0).apply(np.ascontiguousarray(noise.T), rate)))
    (own, before), (new, now) = at[125.0], at[25.0]
    louder = OwnError(rms=np.full(6, before), times=None, period=1 / own.rate).louder([new])
    assert louder == pytest.approx(now / before, rel=0.1)
    assert OwnError(rms=np.full(6, now), times=None, period=1 / new.rate).louder([own]) == 1.0
    (beside,) = beside_own(
        [remainder(1, memory=0.1, rms=now)],
        OwnError(rms=np.array([before]), times=None, period=1 / own.rate),
        np.ones((4, 1)),
        0.0,
        louder,
    )
    assert not beside.structured


def test_what_repeats_with_the_motion_is_no_noise_however_short_it_remembers() -> None:
    """Unless the model's own recordings say that it is usual."""
    short = remainder(1, memory=0.1, rms=1.0)
    for floor, told_so in ((0.5, False), (0.3, True)):
        assert bool(above_noise_floor([short], np.array([floor]))) is told_so
    usual = replace(short, times_own=1.0)
    assert not above_noise_floor([usual], np.array([0.3]))
    assert above_noise_floor(
        [replace(short, times_own=5.0)], np.array([2.0])
    )  # what comes and goes by itself, and is new
