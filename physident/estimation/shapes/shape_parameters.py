"""Shape parameters and model-dependent columns: both must settle before an estimator has a linear problem."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.dynamics.regressor import Regressor, build_regressor, with_transition
from physident.effects.classification import ShapeParameter
from physident.effects.effect import Effect
from physident.estimation.dry_friction.transition_width import with_transitions
from physident.estimation.quick_fit import REFRESHES, SETTLED, quick_fit
from physident.estimation.shapes.curve_priors import with_first_prior
from physident.identifiability.projection import Baseline
from physident.recordings.signals import Filter, Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]
SWEEPS = 5
ROUNDS = 3  # of shapes and of the widths of dry friction, each given the other
REFINED = 1e-2  # relative width at which the search for a shape parameter ends, well below its standard error


def settle(
    robot: Robot, effects: Sequence[Effect], signals: Sequence[Signals], filter: Filter
) -> tuple[tuple[Effect, ...], Regressor]:
    """Effects with every shape parameter set, and the regressor whose model-dependent columns have settled.

    Shape parameters that are not given are identified on the same recordings: the weighted residual after all linear
    parameters are refitted is minimised over a grid and then refined (variable projection: Golub and Pereyra, 1973).
    Shapes and the widths of dry friction are found in turn: a wrong one near zero speed would be mended by the other.
    Columns that depend on the model are rebuilt with weighted least squares until the prediction no longer changes.
    """
    effects = tuple(effects)
    known = [i for i, effect in enumerate(effects) if not _open(effect)]
    turned, regressor = _turned(robot, tuple(effects[i] for i in known), signals, filter)
    if len(known) == len(effects):
        return turned, regressor
    found = turned
    for _ in range(ROUNDS):
        given = _placed(effects, known, turned)
        shaped = _placed(find_shapes(robot, given, signals, filter), known, tuple(effects[i] for i in known))
        found, regressor = _turned(robot, shaped, signals, filter)
        if (now := tuple(found[i] for i in known)) == turned:
            break
        turned = now
    return found, regressor


def _turned(
    robot: Robot, effects: tuple[Effect, ...], signals: Sequence[Signals], filter: Filter
) -> tuple[tuple[Effect, ...], Regressor]:
    """Effects whose shapes are known with the width of every dry friction, and their regressor."""
    return with_transitions(robot, effects, settled_regressor(robot, effects, signals, filter), signals, filter)


def _placed(effects: tuple[Effect, ...], places: list[int], others: tuple[Effect, ...]) -> tuple[Effect, ...]:
    """The effects with ``others`` at some places."""
    chosen = dict(zip(places, others, strict=True))
    return tuple(chosen.get(i, effect) for i, effect in enumerate(effects))


def settled_regressor(
    robot: Robot, effects: tuple[Effect, ...], signals: Sequence[Signals], filter: Filter, theta: Array | None = None
) -> Regressor:
    """The regressor whose model-dependent columns are those of its weighted least squares, iterated until they settle."""
    if not any(effect.needs_model for effect in effects):
        return build_regressor(robot, effects, signals, filter)
    theta = _start(robot, effects, signals, filter) if theta is None else theta
    regressor = build_regressor(robot, effects, signals, filter, theta=theta)
    dependent = [effect for effect in effects if effect.needs_model]
    effect_of_column = [effect for effect in effects for _ in effect.columns(robot)]
    places = np.array([i for i, effect in enumerate(effect_of_column) if effect.needs_model], dtype=np.intp)
    regressor = with_first_prior(robot, effects, regressor)
    for _ in range(REFRESHES):
        after = quick_fit(robot, effects, regressor)
        change = regressor.predict(after) - regressor.predict(theta)
        residual = regressor.residual(after)
        theta = after
        fresh = build_regressor(robot, dependent, signals, filter, model=Model(robot, effects, theta))
        regressor = regressor.with_columns(fresh, places)
        if (np.linalg.norm(change, axis=0) <= SETTLED * np.linalg.norm(residual, axis=0)).all():
            break
    return regressor


def find_shapes(
    robot: Robot, effects: tuple[Effect, ...], signals: Sequence[Signals], filter: Filter
) -> tuple[Effect, ...]:
    """The effects with every shape parameter set; those not given are identified joint by joint."""
    open_effects = [i for i, effect in enumerate(effects) if _open(effect)]
    if not open_effects:
        return effects
    fixed = tuple(effect for i, effect in enumerate(effects) if i not in open_effects)
    signals = [with_transition(robot, fixed, one) for one in signals]  # a candidate alone states no width
    regressor = settled_regressor(robot, fixed, signals, filter)
    weights = _weights(robot, fixed, regressor)
    chosen: dict[tuple[int, int], Effect] = {}
    keys = [(i, joint) for i in open_effects for joint in _joints(effects[i], robot)]
    for sweep in range(SWEEPS):
        changed = False
        for i, joint in keys:
            others = (*fixed, *(effect for key, effect in chosen.items() if key != (i, joint)))
            baseline = Baseline.of(build_regressor(robot, others, signals, filter), weights)
            before = chosen.get((i, joint))
            now = _best(robot, replace(effects[i], joints=(joint,)), before, baseline, signals, filter)
            changed |= before is None or _has_changed(before, now)
            chosen[i, joint] = now
        if not changed or len(keys) == 1:
            break
        if sweep == 0:
            every = (*fixed, *chosen.values())
            weights = _weights(robot, every, build_regressor(robot, every, signals, filter))
    return tuple(_merged(effect, [chosen[k] for k in keys if k[0] == i]) for i, effect in enumerate(effects))


def _best(
    robot: Robot, effect: Effect, before: Effect | None, baseline: Baseline, signals: Sequence[Signals], filter: Filter
) -> Effect:
    """The effect on one joint with the shape parameter of the largest gain: on the grid, then between its neighbours."""
    (shape,) = [s for s in effect.shape_parameters if getattr(effect, s.field) is None]

    def gain(value: float) -> float:
        candidate = build_regressor(robot, [_with(effect, shape, value)], signals, filter)
        return baseline.project(candidate).gain

    grid = np.array(effect.search_grid(robot, effect.joints or (), shape))
    if before is not None and not shape.discrete:
        near = getattr(before, shape.field)[0]
        grid = grid[np.argsort(np.abs(np.log(grid / near)))[:3]]
        grid = np.unique(np.append(grid, near))
    gains = [gain(value) for value in grid]
    top = int(np.argmax(gains))
    if shape.discrete:
        return _with(effect, shape, float(grid[top]))
    low, high = grid[max(0, top - 1)], grid[min(len(grid) - 1, top + 1)]
    from scipy.optimize import minimize_scalar

    found = minimize_scalar(
        lambda x: -gain(float(np.exp(x))),
        bounds=(np.log(low), np.log(high)),
        method="bounded",
        options={"xatol": REFINED},
    )
    value = float(np.exp(found.x)) if -found.fun >= gains[top] else float(grid[top])
    return _with(effect, shape, value)


def _open(effect: Effect) -> bool:
    """Whether one of its shape parameters is still to be identified."""
    by_temperature = getattr(effect, "reference_temperature", None) is not None
    return not by_temperature and any(getattr(effect, shape.field) is None for shape in effect.shape_parameters)


def _joints(effect: Effect, robot: Robot) -> list[int]:
    return [j + 1 for j in effect.active(robot)]


def _with(effect: Effect, shape: ShapeParameter, value: float) -> Effect:
    return replace(effect, **{shape.field: (value,)})


def _has_changed(before: Effect, now: Effect) -> bool:
    return any(abs(getattr(now, s.field)[0] / getattr(before, s.field)[0] - 1) > REFINED for s in now.shape_parameters)


def _merged(effect: Effect, parts: list[Effect]) -> Effect:
    """One effect on all its joints with the shape parameters of its parts."""
    if not parts:
        return effect
    fields = {s.field: tuple(getattr(part, s.field)[0] for part in parts) for s in effect.shape_parameters}
    return replace(effect, **fields)


def _weights(robot: Robot, effects: tuple[Effect, ...], regressor: Regressor) -> Array:
    sizes = regressor.joint_sizes(quick_fit(robot, effects, regressor)) / np.sqrt(len(regressor.time))
    return 1 / np.maximum(sizes, 1e-9 * max(1.0, float(np.abs(regressor.torque).max())))


def _start(robot: Robot, effects: tuple[Effect, ...], signals: Sequence[Signals], filter: Filter) -> Array:
    """First parameters (p,): effects that depend on no model are fitted alone, the others are nominal."""
    plain = tuple(effect for effect in effects if not effect.needs_model)
    if not plain:
        return Model.nominal(robot, effects).theta
    fitted = iter(
        quick_fit(robot, plain, with_first_prior(robot, plain, build_regressor(robot, plain, signals, filter)))
    )
    parts = [
        effect.nominal(robot) if effect.needs_model else np.array([next(fitted) for _ in effect.columns(robot)])
        for effect in effects
    ]
    return np.concatenate(parts)
