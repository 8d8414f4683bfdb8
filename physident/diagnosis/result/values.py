"""The values of a finding's parameters and shapes, with their intervals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import compress

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.learned.describe import curve_in_words, largest_value
from physident.diagnosis.learned.nearest_law import nearest_law
from physident.diagnosis.problem.candidates import AcceptedEffect
from physident.diagnosis.result.contact_force import strongest_push
from physident.diagnosis.result.findings import ParameterValue
from physident.diagnosis.result.wording import listed
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.statistics.intervals import Uncertainty
from physident.dynamics.model import Model
from physident.effects.contact import Contact
from physident.effects.kinds_of_values import OneByOne
from physident.effects.learned.curve import LearnedCurve
from physident.robots.robot import Robot

END = 0.99  # of the largest value that is searched: nearer than the search is exact, and the best may lie beyond
UNFELT = 0.99  # of a prior variance: what is left of it where the data say nothing
SLIDING = 1.0  # rad/s: what builds up over a distance, and what falls with speed, has done so
FARTHEST = 20.0  # of a logarithm: nothing is known of a shape


def parameter_values(
    hypothesis: Hypothesis, accepted: AcceptedEffect, uncertainty: Uncertainty
) -> list[ParameterValue]:
    """The effect's parameters in the extended model, and its shapes; without those that no motion of these recordings shows by themselves, as the
    mass of a hand that turns about its own centre, and the forces of a contact that the arm does not feel."""
    if isinstance(accepted.effect, LearnedCurve):
        return [largest_value(hypothesis, accepted, uncertainty)]
    at = hypothesis.accepted.index(accepted)
    model, effect = hypothesis.extension.model, accepted.effect
    places, (columns, told) = hypothesis.extension.places[at], effect.told(model.robot)
    rows, moves = np.zeros((len(told), len(model.theta))), np.zeros((len(told), len(uncertainty.changes.covariance)))
    rows[:, places], moves[:, hypothesis.places_of_changes[at]] = told, told
    is_new = places.min() >= len(hypothesis.problem.model.theta)
    theta = uncertainty.theta
    if isinstance(effect, Contact):  # only its own block shows its force: its error is that of the fit
        theta = replace(theta, covariance=hypothesis.covariance)
    # what acts on one joint no other contradicts, and of a contact only its own moment says anything
    several = len(np.unique(effect.pattern(model.robot)[:, 0])) > 1 and not isinstance(effect, Contact)
    values, errors, reaches = rows @ model.theta, theta.errors(rows), theta.reach(rows, several)
    changes = values if is_new else told @ hypothesis.effect_values[at]
    halves = reaches if is_new else uncertainty.changes.reach(moves, several)
    result = []
    unfelt = _unfelt(hypothesis, at).ravel() if isinstance(effect, Contact) else hypothesis.left_open(at, told)
    each = zip(columns, values, changes, errors, reaches, halves, strict=True)
    for column, value, change, error, reach, half in compress(each, ~unfelt):
        result.append(
            ParameterValue(
                name=_short(column.name, effect.name),
                joint=column.joint,
                value=float(value),
                change=float(change),
                std=float(error),
                interval95=(float(value - reach), float(value + reach)),
                change_interval95=(float(change - half), float(change + half)),
                unit=column.unit,
            )
        )
    return (
        [*result, *_shapes(accepted, uncertainty, hypothesis.problem.model.robot)]
        if len(accepted.candidate.options) > 1
        else result
    )


def values_in_words(hypothesis: Hypothesis, accepted: Sequence[AcceptedEffect], uncertainty: Uncertainty) -> str:
    """What the effects' values mean in the extended model; empty where names, numbers and units say it. Of values that mean something each by
    itself, those that may be zero are left out."""
    model, sentences = hypothesis.extension.model, []
    for one in accepted:
        at = hypothesis.accepted.index(one)
        if isinstance(one.effect, LearnedCurve):
            sentences.append(
                f"{curve_in_words(hypothesis, one, one.effect, uncertainty)}; {nearest_law(hypothesis, one)}"
            )
        else:
            theta, effect = model.theta[hypothesis.extension.places[at]], one.effect
            if isinstance(effect, OneByOne):
                said = effect.told_in_words(model.robot, _certain_values(hypothesis, one, uncertainty))
            else:
                said = effect.change_in_words(model.robot, theta, theta - hypothesis.effect_values[at])
            sentences.append(said)
            if one.effect.dry and not one.effect.pointwise:
                sentences += [_all_dry_friction(model, j) for j in one.effect.active(model.robot)]
            sentences.append(_only_in_sums(hypothesis, one))
        if isinstance(one.effect, Contact):
            never = [f"F{axis}" for axis, each in zip("xyz", _unfelt(hypothesis, at).T, strict=True) if each.all()]
            sentences.append(f"The arm does not feel {' or '.join(never)}." if never else "")
    sentences.append(strongest_push(hypothesis, accepted))
    return " ".join(filter(None, dict.fromkeys(sentences)))  # two contacts say the same


def _certain_values(hypothesis: Hypothesis, accepted: AcceptedEffect, uncertainty: Uncertainty) -> NDArray[np.float64]:
    """What is told (r,) of an accepted effect, zero where it may be."""
    effect = accepted.effect
    values = parameter_values(hypothesis, accepted, uncertainty)
    certain = {(v.name, v.joint): v.value for v in values if not v.interval95[0] <= 0 <= v.interval95[1]}
    columns, _ = effect.told(hypothesis.problem.model.robot)
    return np.array([certain.get((_short(column.name, effect.name), column.joint), 0.0) for column in columns])


def _only_in_sums(hypothesis: Hypothesis, accepted: AcceptedEffect) -> str:
    """Which numbers of an effect these recordings show in sums alone; empty where each has a value of its own."""
    at, effect = hypothesis.accepted.index(accepted), accepted.effect
    columns, told = effect.told(hypothesis.problem.model.robot)
    values = told @ hypothesis.effect_values[at]
    each = zip(columns, values, hypothesis.left_open(at, told), strict=True)
    names = [_short(column.name, effect.name) for column, value, is_open in each if is_open and value != 0]
    place = " and ".join(f" of joint {joint}" for joint in accepted.candidate.joints)
    return (
        f"These motions show {listed(names)}{place} only in sums: none of them has a value of its own." if names else ""
    )


def _all_dry_friction(model: Model, joint: int) -> str:
    """How much dry friction a joint (from 0) has where friction that builds up over a distance is a part of it; empty where it is all."""
    speed, parts = np.full(model.robot.n, SLIDING) * model.robot.radian, []
    for effect, theta in model.effect_parameters():
        if effect.dry:
            mine = np.array([column.joint == joint + 1 for column in effect.columns(model.robot)])
            parts.append(float((theta * mine) @ effect.friction(model.robot, speed)[:, joint]))
    if np.count_nonzero(parts) < 2:
        return ""
    return f"With the other dry friction of joint {joint + 1} it is {sum(parts):.3g} {model.robot.joints[joint].unit('N m')}."


def _unfelt(hypothesis: Hypothesis, at: int) -> NDArray[np.bool_]:
    """Of which forces (pieces, 3) of an accepted contact only the prior is known: across its plane a planar arm feels none."""
    return (hypothesis.left_to_prior(at) > UNFELT).reshape(-1, 3)


def _shapes(accepted: AcceptedEffect, uncertainty: Uncertainty, robot: Robot) -> list[ParameterValue]:
    """The shapes that were searched; they are searched, and known, by their logarithm."""
    effect, joint, result = accepted.effect, (accepted.candidate.joints or (0,))[0], []
    for shape in effect.shape_parameters:
        if getattr(effect, shape.field) is None:
            continue
        value, error = float(getattr(effect, shape.field)[0]), uncertainty.shape_errors.get(accepted.candidate.key, 0.0)
        reach = float(np.exp(min(uncertainty.half * error / value, FARTHEST)))
        tried = _searched(accepted, shape.field)
        at_end = error > 0 and not min(tried) / END < value < max(tried) * END
        ends = (value / reach, value * reach)
        result.append(
            ParameterValue(
                name=shape.field,
                joint=joint,
                value=value,
                change=value,
                std=error,
                interval95=ends,
                change_interval95=ends,
                unit=robot.joints[joint - 1].unit(shape.unit),
                at_end=at_end,
            )
        )
    return result


def _searched(accepted: AcceptedEffect, field: str) -> list[float]:
    """The values of a shape that its candidate was tried with."""
    effects = [option.effect for option in accepted.candidate.options]
    return [float(values[0]) for e in effects if (values := getattr(e, field, None)) is not None]


def _short(name: str, effect: str) -> str:
    """A column's name without its effect and joint, where something is left: payload_mass is mass."""
    rest = name.removeprefix(effect).lstrip("_")
    stem = "_".join(part for part in rest.split("_") if not part.isdigit())
    return stem or effect
