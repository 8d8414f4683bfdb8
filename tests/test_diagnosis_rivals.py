"""Rivals are those that the data cannot tell apart, no others; and what others make superfluous is removed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.problem.candidates import Candidate
from physident.diagnosis.result.assemble import _shapes
from physident.diagnosis.search import acceptance as gates
from physident.diagnosis.search import forward_search as search
from physident.diagnosis.search.acceptance import choose
from physident.diagnosis.search.candidate_scores import look
from physident.diagnosis.search.forward_search import settled
from physident.diagnosis.search.hypothesis import Accepted, State
from physident.diagnosis.search.rivals import examine
from physident.diagnosis.statistics.intervals import certainty
from tests.opened import opened
from tests.plant import Arm

JOINT = 3


@pytest.fixture(scope="module")
def rubbing(ur5: pid.Robot, healthy_runs: list[pid.Recording]) -> State:
    """Dry friction of one joint doubled, viscous friction of it too."""
    v = healthy_runs[2].dq
    assert v is not None
    friction = Arm().friction
    more = friction.coulomb * np.tanh(v / 0.01) + friction.viscous * v
    return opened(ur5, healthy_runs[:3], more * (np.arange(6) == JOINT - 1))


def candidate(state: State, name: str, joint: int = JOINT) -> Candidate:
    (found,) = (c for c in state.evidence.candidates if c.key == (name, (joint,)))
    return found


def accepted(state: State, *keys: tuple[str, int]) -> tuple[Accepted, ...]:
    made = []
    for name, joint in keys:
        own = candidate(state, name, joint)
        assert own.options[0].effect is not None
        made.append(Accepted(own, own.options[0].effect))
    return tuple(made)


def test_the_search_ends_where_a_placebo_comes_next(rubbing: State) -> None:
    """A real effect would pass behind it: what follows a column that cannot be a cause is worth no more."""
    now = look(rubbing)
    top = choose(now)
    assert top is not None
    assert now.state.evidence.candidates[top].joints == (JOINT,)
    first = next(i for i, c in enumerate(now.state.evidence.candidates) if c.placebo)
    gain, least, share = now.gain.copy(), now.least.copy(), now.share.copy()
    gain[first], least[first], share[first] = 2 * gain.max(), 2 * least.max(), 1.0
    assert choose(replace(now, gain=gain, least=least, share=share)) is None


def test_as_good_is_what_the_scatter_over_blocks_cannot_tell(rubbing: State, monkeypatch: pytest.MonkeyPatch) -> None:
    blocks = np.random.default_rng(0).normal(size=(50, 6))
    error = np.sqrt(50) * blocks.sum(axis=1).std(ddof=1)
    one, other = candidate(rubbing, "viscous_friction"), candidate(rubbing, "coulomb_friction")
    for excess, expected in ((1.0, True), (2.5, False)):
        loss = blocks + (excess * error - blocks.sum()) / blocks.size
        monkeypatch.setattr(gates, "costs", lambda *_, loss=loss: loss)
        assert gates.as_good(rubbing, other, np.zeros((50, 6)), rubbing.fit.weights) is expected, (one, excess)


def test_of_two_effects_at_work_neither_replaces_the_other(rubbing: State) -> None:
    dry, wet = candidate(rubbing, "coulomb_friction"), candidate(rubbing, "viscous_friction")
    threshold = look(rubbing).threshold
    assert not gates.replaces(rubbing, dry, wet, threshold)
    assert not gates.replaces(rubbing, wet, dry, threshold)
    assert gates.replaces(rubbing, dry, dry, threshold)


def test_each_of_two_effects_has_no_rival_in_the_other(rubbing: State) -> None:
    state = settled(rubbing.case, accepted(rubbing, ("coulomb_friction", JOINT), ("viscous_friction", JOINT)))
    now = look(state)
    for one in state.accepted:
        examined = examine(now, one)
        assert examined.gain > now.threshold
        assert not {c.name for c in examined.rivals} & {"coulomb_friction", "viscous_friction"}


def test_what_another_effect_makes_superfluous_is_removed(rubbing: State) -> None:
    true = (("coulomb_friction", JOINT), ("viscous_friction", JOINT))
    every = accepted(rubbing, *true, ("coulomb_friction", 5), ("friction_asymmetry", JOINT))
    kept = search._trimmed(rubbing.case, every, look(settled(rubbing.case, every)))
    assert {(a.candidate.name, a.candidate.joints[0]) for a in kept} == set(true)


def test_a_shape_beyond_the_grid_is_said_to_lie_at_its_end(rubbing: State) -> None:
    """There the value is a bound; and a length, known by its logarithm, is never negative."""
    own = candidate(rubbing, "presliding_hysteresis")
    options = [o.effect for o in own.options if o.effect is not None]
    for place, at_end in ((0, True), (len(options) // 2, False), (len(options) - 1, True)):
        state = settled(rubbing.case, (Accepted(own, options[place]),))
        (shape,) = _shapes(state.accepted[0], certainty(state))
        assert shape.at_end is at_end, place
        low, high = shape.interval95
        assert 0 < low < shape.value < high
        assert low * high == pytest.approx(shape.value**2)
