"""Grades: what a finding must take, leave and hold to be a cause, and what unseen recordings take from it."""

from __future__ import annotations

import warnings
from dataclasses import fields, replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.grading import grades
from physident.diagnosis.grading import members as member_effects
from physident.diagnosis.grading.grades import ExpectedError, graded
from physident.diagnosis.grading.holdout import errs_more_where
from physident.diagnosis.judged import Judged, as_hints
from physident.diagnosis.problem.candidates import AcceptedEffect
from physident.diagnosis.result.findings import Finding, ParameterValue, Reduction
from physident.diagnosis.result.wording import trust_in_words
from physident.diagnosis.search.forward_search import HANDFUL, settled_hypothesis
from physident.effects.contact import Contact
from tests.opened import opened
from tests.plant import Arm
from tests.searched_once import searched_once

NOISE = np.full(2, 0.5)  # N m, that even a right model leaves


def level(rms: np.ndarray) -> ExpectedError:
    """What even a right model leaves is what the model usually errs by."""
    return ExpectedError(right=rms, usual=rms)


def hypothesis() -> Any:
    """Two joints of equal noise, whose rows all count in full."""
    full = np.ones((100, 2))
    problem = SimpleNamespace(
        weights=full,
        regressor=SimpleNamespace(counted=full > 0),
        all_compared=False,
        question="different",
        model=SimpleNamespace(robot=None),
    )
    return cast(Any, SimpleNamespace(fit=SimpleNamespace(sigma=NOISE), problem=problem, accepted=()))


@pytest.fixture(autouse=True)
def shown_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    """Findings of the made-up hypothesis show alike on both joints, where a test does not say otherwise."""

    def shown(of: Any, group: Any) -> Any:
        return np.full(2, 0.5) if isinstance(of, SimpleNamespace) else member_effects.where_it_shows(of, group)

    monkeypatch.setattr(grades, "where_it_shows", shown)


def finding(before: float, after: float, **more: Any) -> Finding:
    gain = Reduction(
        rms_before=before, rms_after=after, reduction_percent=100 * (1 - after / before), interval95=(1, 99)
    )
    value = ParameterValue(
        name="mass",
        joint=1,
        value=2.0,
        change=2.0,
        std=0.1,
        interval95=(1.8, 2.2),
        change_interval95=(1.8, 2.2),
        unit="kg",
    )
    made = Finding(
        effect="payload",
        joints=(1, 2),
        parameters=(value,),
        gain=gain,
        rivals=(),
        intervals=(),
        advice="",
        evidence=before,
    )
    return replace(made, **more)


def grade(one: Finding) -> str:
    return graded(hypothesis(), [one], level(NOISE))[0].grade


def test_a_cause_takes_more_than_is_left_above_the_noise() -> None:
    # squares: of 1.25 one takes 0.6 and leaves 0.4 above the noise, the other takes 0.4 and leaves 0.6
    more, less = finding(1.25**0.5, 0.65**0.5), finding(1.25**0.5, 0.85**0.5)
    assert (grade(more), grade(less)) == ("cause", "contribution")
    found = graded(hypothesis(), [less, more], level(NOISE))
    assert [f.grade for f in found] == ["cause", "contribution"]
    assert found[0].takes_percent == pytest.approx(100 * 0.6 / 1.25)
    assert found[0].leaves_percent == pytest.approx(100 * 0.4 / 1.25)


def test_what_is_small_beside_the_noise_is_no_cause_though_it_leaves_nothing() -> None:
    """A right model leaves half a newton metre: what lowers the RMS by 2 % changes no prediction, 4 % does."""
    assert grade(finding(0.5 / 0.98, 0.5)) == "contribution"
    assert grade(finding(0.5 / 0.96, 0.5)) == "cause"
    # a model that now leaves less than a right one does may take up noise: what counts is what even a right one leaves
    assert grade(finding(0.13, 0.1)) == "contribution"


def test_what_a_comparison_proves_must_still_be_noticed_beside_the_models_usual_error() -> None:
    """Where the model's error was taken off, a right model leaves next to nothing; a user simulates with the error all the same."""
    tiny, usual = np.full(2, 0.001), np.full(2, 0.5)
    taken_off = ExpectedError(right=tiny, usual=usual)
    small, large, half = finding(0.1, 0.01), finding(0.3, 0.01), finding(0.3, 0.25)
    grades_of = [graded(hypothesis(), [one], taken_off)[0].grade for one in (small, large, half)]
    assert grades_of == ["contribution", "cause", "contribution"]


def test_a_finding_is_judged_where_it_shows(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first joint's residual is structure, the second's noise: what only the second feels is a cause, and what only the first feels
    is none."""
    one, expected = finding(1.0, 0.8), level(np.array([0.1, 0.8]))
    for where, told in (([0.0, 1.0], "cause"), ([1.0, 0.0], "contribution")):
        monkeypatch.setattr(grades, "where_it_shows", lambda *_, where=where: np.array(where))
        assert graded(hypothesis(), [one], expected)[0].grade == told


def test_what_is_noticed_on_one_joint_is_a_cause_though_others_hardly_feel_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside the first joint, which usually errs by 6 N m, it is nothing, and beside the second's 0.5 N m most of it."""
    small = np.full(2, 0.01)
    expected = ExpectedError(right=small, usual=np.array([6.0, 0.5]))
    for where, told in (([0.5, 0.5], "cause"), ([1.0, 0.0], "contribution")):
        monkeypatch.setattr(grades, "where_it_shows", lambda *_, where=where: np.array(where))
        assert graded(hypothesis(), [finding(0.5, 0.01)], expected)[0].grade == told


def test_along_the_same_motions_a_cause_takes_twice_what_it_leaves() -> None:
    """Nothing but the change is left there, so a law that leaves a part of it has not its shape."""
    of, exact = hypothesis(), level(np.full(2, 1e-3))
    of.problem.all_compared = True
    less, more = finding(1.0, 0.36**0.5), finding(1.0, 0.3**0.5)  # of 1, 0.64 and 0.7 are taken
    assert [graded(of, [one], exact)[0].grade for one in (less, more)] == ["contribution", "cause"]
    assert grade(less) == "cause"  # of another motion: the model's own errors stay


def test_what_a_finding_changes_of_the_residual_says_where_it_shows(monkeypatch: pytest.MonkeyPatch) -> None:
    complete = hypothesis()
    complete.fit.sigma, complete.fit.residual = np.array([2.0, 0.5]), np.zeros((100, 2))
    rest = SimpleNamespace(fit=SimpleNamespace(residual=np.tile([1.0, 0.5], (100, 1))))
    monkeypatch.setattr(member_effects, "without_effects", lambda *_: rest)
    # 1 N m is half the noise of the first joint, 0.5 N m the whole noise of the second: four fifths of the power
    assert member_effects.where_it_shows(complete, [0]) == pytest.approx([0.2, 0.8])


VAGUE = ParameterValue(
    name="mass", joint=1, value=0.2, change=0.2, std=0.2, interval95=(-0.2, 0.6), change_interval95=(-0.2, 0.6),
    unit="kg",
)  # fmt: skip


def test_a_value_that_may_be_the_old_one_makes_no_cause() -> None:
    sure = replace(VAGUE, change_interval95=(0.05, 0.35))
    assert [grade(finding(2.0, 0.5, parameters=(one,))) for one in (VAGUE, sure)] == ["contribution", "cause"]


def test_a_shape_that_is_known_makes_no_cause_of_values_that_may_all_be_zero() -> None:
    """A time constant is never zero, whatever fades with it; of one value and its shape, either may stand for the other."""
    coulomb, viscous = replace(VAGUE, name="coulomb"), replace(VAGUE, name="viscous")
    shape = replace(
        VAGUE, name="time_constant", value=9.0, change=9.0, interval95=(5.0, 16.0), change_interval95=(5.0, 16.0)
    )
    sure = replace(coulomb, value=1.0, change=1.0, interval95=(0.8, 1.2), change_interval95=(0.8, 1.2))
    grades = [
        grade(finding(2.0, 0.5, effect="warm_up", parameters=some))
        for some in ((coulomb, viscous, shape), (sure, viscous, shape), (coulomb, shape))
    ]
    assert grades == ["contribution", "cause", "cause"]


def test_what_is_sure_of_none_of_its_values_makes_no_cause() -> None:
    """A payload of no mass, no first moment and no inertia is a torque that differs, and no load."""
    sure = replace(VAGUE, name="mcx", value=1.0, change=1.0, interval95=(0.8, 1.2), change_interval95=(0.8, 1.2))
    several = [finding(2.0, 0.5, parameters=some) for some in ((VAGUE, VAGUE), (VAGUE, sure))]
    assert [grade(one) for one in several] == ["contribution", "cause"]


def test_a_contribution_that_takes_more_than_it_leaves_says_why_it_is_no_cause() -> None:
    def reason(one: Finding, compared: bool = False, noise: np.ndarray = NOISE, question: str = "different") -> str:
        of = hypothesis()
        of.problem.all_compared, of.problem.question = compared, question
        (told,) = graded(of, [one], level(noise))
        assert told.grade == "contribution"
        return told.no_cause

    open_value = finding(2.0, 0.5, parameters=(VAGUE,))
    assert reason(open_value) == "each of its values may be the model's own"
    assert "may be zero" in reason(open_value, question="missing")
    unsure = Reduction(rms_before=2.0, rms_after=0.5, reduction_percent=75.0, interval95=(-5.0, 90.0))
    assert "predicted as well without it" in reason(finding(2.0, 0.5, gain=unsure))
    assert "small beside what the model errs by" in reason(finding(0.5 / 0.98, 0.5))
    assert "takes twice what it leaves" in reason(finding(1.0, 0.36**0.5), compared=True, noise=np.full(2, 1e-3))
    # where it leaves more than it takes, the two numbers say it
    assert reason(finding(1.25**0.5, 0.85**0.5)) == ""
    # a cause and a hint have no such reason
    for one in (finding(2.0, 0.5), finding(2.0, 0.5, parameters=(VAGUE,), doubts=("unstable",))):
        assert graded(hypothesis(), [one], level(NOISE))[0].no_cause == ""


def test_a_doubt_makes_a_hint_however_much_it_takes() -> None:
    assert grade(finding(9.0, 0.5, doubts=("its sign changes between recordings",))) == "hint"


def pushed(left: float, forces: int = 3, memory: float = 2.0, unfelt: int = 0) -> tuple[Any, Any]:
    """Ten seconds of two joints with the same residual everywhere, and of those without a contact from 2 to 3 s, which takes
    its power there down to ``left``; of its ``forces`` the arm does not feel some."""
    time = np.arange(100) / 10
    during = (time >= 2) & (time < 3)
    made = hypothesis()
    made.problem.regressor.time, made.problem.regressor.recording = time, np.zeros(100, dtype=int)
    made.problem.signals = [SimpleNamespace(recording="a", origin=0.0)]
    made.accepted = (
        SimpleNamespace(candidate=SimpleNamespace(name="contact", joints=()), effect=Contact(recording="a")),
    )
    made.left_to_prior = lambda _: (np.arange(forces) < unfelt).astype(float)
    made.fit.memory = np.full(2, memory)
    made.fit.residual = np.where(during[:, None], left**0.5, 1.0) * np.ones((100, 2))
    return made, SimpleNamespace(fit=SimpleNamespace(residual=np.ones((100, 2))))


@pytest.mark.parametrize(
    ("left", "forces", "memory", "expected"),
    [
        (0.3, 3, 2.0, "cause"),  # though it takes one part in a hundred of the whole recording
        (0.5, 3, 2.0, "contribution"),
        (
            0.3,
            8,
            2.0,
            "contribution",
        ),  # as many forces as there are samples to spare: what they take they would take of noise
        (0.3, 3, 5.0, "contribution"),
    ],
)
def test_a_contact_is_judged_while_it_lasts(
    left: float, forces: int, memory: float, expected: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    complete, rest = pushed(left, forces, memory)
    monkeypatch.setattr(grades, "without", lambda *_: rest)
    contact = finding(1.0, 0.995, effect="contact", joints=(), intervals=((2.0, 3.0),), recording="a")
    assert graded(complete, [contact], level(np.full(2, 0.01)))[0].grade == expected
    # no other block of time shows a contact: that some blocks fare worse with it says nothing
    once = replace(contact, gain=replace(contact.gain, interval95=(-1.0, 9.0)))
    assert graded(complete, [once], level(np.full(2, 0.01)))[0].grade == expected
    whole = replace(contact, gain=replace(contact.gain, rms_after=0.5))  # all that the recording shows is the contact
    assert graded(complete, [whole], level(np.full(2, 0.01)))[0].grade == (
        "cause" if (forces, memory) == (3, 2.0) else "contribution"
    )


def test_what_left_out_rows_do_not_miss_is_a_hint() -> None:
    needless = graded(hypothesis(), [finding(1.0, 1.03)], level(np.full(2, 0.01)))[0]
    assert (needless.grade, needless.doubts) == ("hint", (grades.NEEDLESS,))


def test_forces_that_the_arm_does_not_feel_cost_no_samples(monkeypatch: pytest.MonkeyPatch) -> None:
    """A planar arm feels two of three: the third stays what its prior says, and takes nothing of the noise."""
    grade = {}
    for unfelt in (0, 5):
        complete, rest = pushed(0.3, forces=8, unfelt=unfelt)
        monkeypatch.setattr(grades, "without", lambda *_, rest=rest: rest)
        contact = finding(1.0, 0.995, effect="contact", joints=(), intervals=((2.0, 3.0),), recording="a")
        grade[unfelt] = graded(complete, [contact], level(np.full(2, 0.01)))[0].grade
    assert grade == {0: "contribution", 5: "cause"}


def test_a_handful_is_fewer_than_the_families_of_effects() -> None:
    """An arm has one fault or two at a time; findings of every family at once are a baseline that is wrong throughout."""
    assert 2 < HANDFUL < len({effect.family for effect in pid.CATALOGUE.values()})


@pytest.mark.slow
def test_what_unseen_recordings_refute_is_no_cause_and_is_not_carried(
    healthy_runs: list[pid.Recording], healthy_estimate: pid.Estimate, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Friction that one recording has, and the next has not."""
    searched_once(monkeypatch)
    run, unseen = healthy_runs[2:4]
    assert run.dq is not None
    rubbing = replace(run, effort=run.effort + 3.0 * np.sign(run.dq) * Arm().friction.coulomb * (np.arange(6) == 2))
    with warnings.catch_warnings(action="ignore", category=pid.PhysidentWarning):
        alone = pid.diagnose_motion(healthy_estimate, [rubbing])
        refuted = pid.diagnose_motion(healthy_estimate, [rubbing], [unseen])
    assert {(f.effect, f.joints) for f in alone.causes} == {("coulomb_friction", (3,))}
    assert alone.extended is not None
    assert refuted.causes == ()
    assert {f.grade for f in refuted.findings} == {"hint"}
    assert "not confirmed on unseen data" in refuted.findings[0].doubts
    assert refuted.extended is None


def test_the_model_that_is_handed_on_is_judged_where_its_findings_act(
    ur5: pid.Robot, healthy_runs: list[pid.Recording], healthy_estimate: pid.Estimate
) -> None:
    """A second fit that settles joint 3 worse refutes what acts there, and nothing else; one that settles it better refutes nothing."""
    v = healthy_runs[2].dq
    assert v is not None
    state = opened(ur5, healthy_runs[:3], 2.0 * np.sign(v) * np.isin(np.arange(6), (1, 2)))
    keys = [("coulomb_friction", (joint,)) for joint in (2, 3)]
    found = {c.key: c for c in state.data.candidates}
    effects = [found[key].options[0].effect for key in keys]
    accepted = [AcceptedEffect(found[k], e) for k, e in zip(keys, effects, strict=True) if e is not None]
    both = settled_hypothesis(state.problem, accepted)
    theta = both.problem.model.theta
    at = [c.name for c in both.problem.model.columns].index("viscous_friction_3")
    spoilt = pid.Model(ur5, both.problem.model.effects, theta + 50.0 * (np.arange(len(theta)) == at))
    held = healthy_runs[3:4]
    assert errs_more_where(both, [[0], [1], []], held, None, spoilt) == [False, True, False]
    assert errs_more_where(both, [[0], [1], []], held, None, both.problem.model) == [False, False, False]


def test_a_reason_is_said_once_in_text_and_report() -> None:
    told = finding(2.0, 0.5, grade="contribution", no_cause="each of its values may be zero", stability=0.9)
    words = trust_in_words(told)
    assert words.count("no cause") == 1
    assert words.startswith("A contribution, no cause: each of its values may be zero, found in 18 of 20 searches")


def test_a_hint_has_doubts_and_no_reason_of_a_contribution() -> None:
    lesser = finding(2.0, 0.5, grade="contribution", no_cause="each of its values may be zero")
    open_fields: dict[str, Any] = dict.fromkeys(one.name for one in fields(Judged))
    (told,) = as_hints(Judged(**{**open_fields, "findings": (lesser,), "old": ()})).findings
    assert (told.grade, told.no_cause) == ("hint", "")
    assert told.doubts
