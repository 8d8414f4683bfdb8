"""From accepted effects to findings: joined over joints, with values, intervals, gains and rivals."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.evidence import blocks
from physident.diagnosis.problem.question import Question
from physident.diagnosis.result.findings import Finding, Reduction, Rival, Value
from physident.diagnosis.search.contact import CONTACT, scan
from physident.diagnosis.search.hypothesis import Accepted, State
from physident.diagnosis.search.rivals import Examined
from physident.diagnosis.statistics.intervals import RESAMPLES, Certainty, resampled_reduction
from physident.diagnosis.statistics.left_out_residuals import block_costs
from physident.effects.catalogue import CATALOGUE, effect_scope
from physident.effects.contact import Contact

Array = NDArray[np.float64]
SCALED = (
    "Found from currents: the mass scales with the drive gains; physident drive-gains finds them with a known load."
)
END = 0.99  # of the largest value that is searched: nearer than the search is exact, and the best may lie beyond
FARTHEST = 20.0  # of a logarithm: nothing is known of a shape


def findings(
    state: State, examined: Sequence[Examined], sure: Certainty, currents: bool = False
) -> tuple[Finding, ...]:
    """One finding for each cause, the same effect on several joints joined, in order of left-out gain; a payload found from
    ``currents`` says what its mass depends on."""
    groups: dict[object, list[Examined]] = {}
    for one in examined:
        name = one.accepted.candidate.name
        key = name if effect_scope(name).joins_joints else one.accepted.candidate.key
        groups.setdefault((key, getattr(one.accepted.effect, "recording", "")), []).append(one)
    made = [_finding(state, group, sure, currents) for group in groups.values()]
    return tuple(sorted(made, key=lambda f: -f.evidence))


def _finding(state: State, group: Sequence[Examined], sure: Certainty, currents: bool) -> Finding:
    group = sorted(group, key=lambda e: e.accepted.candidate.joints)
    name = group[0].accepted.candidate.name
    joints = tuple(j for e in group for j in e.accepted.candidate.joints)
    values = tuple(v for e in group for v in _values(state, e.accepted, sure))
    rivals = _joined([c.key for e in group for c in e.rivals])
    contacts = tuple(i for e in group for i in getattr(e.accepted.effect, "intervals", ()))
    return Finding(
        name, joints, values, _reduction(state, [e.accepted for e in group], joints), rivals, contacts,
        " ".join(filter(None, (SCALED if currents and name == "payload" else "", _advice(state.case.question, name, joints, rivals)))), float(sum(e.gain for e in group)),
        getattr(group[0].accepted.effect, "recording", ""),
    )  # fmt: skip


def _joined(keys: Sequence[tuple[str, tuple[int, ...]]]) -> tuple[Rival, ...]:
    """Rivals of one name joined over joints."""
    found: dict[object, set[int]] = {}
    for name, joints in keys:
        found.setdefault((name,) if effect_scope(name).joins_joints else (name, joints), set()).update(joints)
    return tuple(Rival(key[0], tuple(sorted(joints))) for key, joints in found.items())  # pyright: ignore[reportIndexIssue]


def _reduction(state: State, group: Sequence[Accepted], joints: Sequence[int]) -> Reduction:
    rest = state.case.state([a for a in state.accepted if a not in group], state.model, state.evidence)
    if group[0].candidate is CONTACT:
        return _touch(state, rest, group)
    weights = 1 / state.fit.sigma
    own = [j - 1 for j in joints] or list(range(len(weights)))
    labels = blocks(state.evidence, float(state.fit.memory.max()))
    columns = [state.case.columns(a.effect, state.model) for a in group]
    joined = [np.column_stack(own) for own in zip(*columns, strict=True)]
    before, after = (block_costs(rest.folded.residual(o), weights, labels)[:, own] for o in ([], [joined]))
    rows = np.count_nonzero(labels >= 0) * np.sum(weights[own] ** 2)
    low, high = resampled_reduction(before.sum(axis=1), after.sum(axis=1), state.case.seed)
    sizes = [float(np.sqrt(x.sum() / rows)) for x in (before, after)]
    return Reduction(sizes[0], sizes[1], 100 * (1 - sizes[1] / sizes[0]) if sizes[0] > 0 else 0.0, (low, high))


def _touch(state: State, rest: State, group: Sequence[Accepted]) -> Reduction:
    """What contacts gain as the search judged them: each joint by the force that the others tell; all joints, noise-weighted."""
    weights, each = rest.fit.weights, []
    for one in group:
        beside = state.case.state([a for a in state.accepted if a is not one], state.model, state.evidence)
        windows = scan(beside, beside.evidence.response[:, :, None]).windows
        each.append((windows * (weights / beside.fit.weights) ** 2).sum(axis=1))
    gain = np.concatenate(each)
    before = float(np.sum((rest.fit.residual * weights) ** 2))
    draws = np.random.default_rng([rest.case.seed, 17]).integers(0, len(gain), (RESAMPLES, len(gain)))
    left = np.sqrt(np.maximum(1 - np.append(gain[draws].sum(axis=1), gain.sum()) / before, 0.0))
    low, high = np.quantile(100 * (1 - left[:-1]), (0.025, 0.975))
    size = float(np.sqrt(before / (len(rest.fit.residual) * np.sum(weights**2))))
    return Reduction(size, size * float(left[-1]), 100 * (1 - float(left[-1])), (float(low), float(high)))


def _values(state: State, accepted: Accepted, sure: Certainty) -> list[Value]:
    """The effect's parameters in the extended model, and its shapes."""
    at = state.accepted.index(accepted)
    model, effect = state.extension.model, accepted.effect
    # no block but its own shows a contact's force: its error is that of the fit
    covariance = state.covariance if isinstance(effect, Contact) else sure.covariance
    old = {c.name: float(v) for c, v in zip(state.case.model.columns, state.case.model.theta, strict=True)}
    result = []
    for column, place in zip(effect.columns(model.robot), state.extension.places[at], strict=True):
        value, error = float(model.theta[place]), float(np.sqrt(max(covariance[place, place], 0.0)))
        ends = (value - sure.half * error, value + sure.half * error)
        change = value - old.get(column.name, 0.0)
        result.append(Value(_short(column.name, effect.name), column.joint, value, change, error, ends, column.unit))
    return [*result, *_shapes(accepted, sure)] if len(accepted.candidate.options) > 1 else result


def _shapes(accepted: Accepted, sure: Certainty) -> list[Value]:
    """The shapes that were searched; they are searched, and known, by their logarithm."""
    effect, joint, result = accepted.effect, (accepted.candidate.joints or (0,))[0], []
    for shape in effect.shape_parameters:
        if getattr(effect, shape.field) is None:
            continue
        value, error = float(getattr(effect, shape.field)[0]), sure.shapes.get(accepted.candidate.key, 0.0)
        reach = float(np.exp(min(sure.half * error / value, FARTHEST)))
        tried = _searched(accepted, shape.field)
        at_end = error > 0 and not min(tried) / END < value < max(tried) * END
        ends = (value / reach, value * reach)
        result.append(Value(shape.field, joint, value, value, error, ends, shape.unit, at_end))
    return result


def _searched(accepted: Accepted, field: str) -> list[float]:
    """The values of a shape that its candidate was tried with."""
    effects = [option.effect for option in accepted.candidate.options]
    return [float(values[0]) for e in effects if (values := getattr(e, field, None)) is not None]


def _short(name: str, effect: str) -> str:
    """A column's name without its effect and joint, where something is left: payload_mass is mass."""
    rest = name.removeprefix(effect).lstrip("_")
    stem = "_".join(part for part in rest.split("_") if not part.isdigit())
    return stem or effect


def _advice(question: Question, name: str, joints: Sequence[int], rivals: Sequence[Rival]) -> str:
    """What would separate the first rival that is another effect."""
    other = next((r for r in rivals if r.effect != name), None)
    return separating(question, name, joints, other) if other is not None else ""


def separating(question: Question, name: str, joints: Sequence[int], other: Rival) -> str:
    """What separates an effect on some joints from another one: its signature's words where the catalogue has them, and the
    command that designs the motion."""
    told = ((other.effect, CATALOGUE[name].mistaken_for), (name, CATALOGUE[other.effect].mistaken_for))
    said = [f"{text}. " for own, text in told if own in text][:1]
    common = [j for j in joints if j in other.joints]
    joint = f" --joint {common[0]}" if common else ""
    # a design needs to know the noise, which a nominal model does not
    model = "EXTENDED" if question == "nominal" else "MODEL"
    command = f"physident design --model {model} --discriminate {name} {other.effect}{joint} --out motion.json"
    return f"{said[0] if said else ''}The motion that does: {command}"
