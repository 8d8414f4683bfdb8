"""The contract of an effect, as a check to run on effects of one's own: shapes, units, one instant at a time, files, export."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.effects.catalogue import CATALOGUE, ORIGIN
from physident.effects.classification import Detection, Scope
from physident.effects.effect import Effect
from physident.effects.user.guarded import LARGEST, read_only
from physident.effects.user.registration import check_class
from physident.errors import InputError
from physident.identifiability.base_parameters import random_motion
from physident.recordings.signals import Signals
from physident.robots.load import load_robot
from physident.robots.robot import Robot

Array = NDArray[np.float64]
CLOSE = 1e-9  # relative, of two ways to compute one torque
PART = slice(100, 110)  # samples of the motion that are evaluated alone


def check_effect(effect: Effect | type[Effect], robot: Robot | str = "ur5", seed: int = 0) -> None:
    """Check an effect, or a class of effects with its shapes in the middle of their grids, against the contract of all effects.

    The class as ``--effects-from`` requires it; then, on a random motion of ``robot``: shapes and units of its columns, the same
    values (E, N) [N m|N] for a part of a motion as for the whole, the simulator's torque, energy where the effect is ``passive``,
    its text in a file, and its NumPy source. Raises
    AssertionError with one line for each clause that is broken, and InputError for a robot that does not exist.
    """
    arm = load_robot(robot) if isinstance(robot, str) else robot
    kind = type(effect) if isinstance(effect, Effect) else effect
    try:
        check_class(CATALOGUE, kind, getattr(kind, "origin", "") or "checked")
    except InputError as error:
        raise AssertionError(str(error)) from None
    one = effect if isinstance(effect, Effect) else effect.at_grid_middle(arm)
    motion = _motion(arm, seed)
    broken = [line for clause in CLAUSES for line in _kept(clause, one, arm, motion)]
    if broken:
        raise AssertionError("\n".join(f"{type(one).__name__}: {line}" for line in broken))


def _kept(clause: Callable[..., Iterator[str]], effect: Effect, robot: Robot, motion: Signals) -> list[str]:
    try:
        return list(clause(effect, robot, motion))
    except Exception as error:  # what an effect's code raises is what is wrong with it
        return [f"{clause.__name__.strip('_').replace('_', ' ')}: {type(error).__name__}: {error}"]


def _motion(robot: Robot, seed: int) -> Signals:
    """A random motion that a model with friction and offsets has been evaluated on."""
    model = Model.nominal(robot)
    added = np.random.default_rng(seed).uniform(0.5, 2.0, len(model.theta)) * (model.theta == 0)
    arm = Model(robot, model.effects, model.theta + added * _others(model))
    return read_only(arm.refer(random_motion(robot, seed)))


def _others(model: Model) -> Array:
    return np.array([float(column.effect != "rigid_body") for column in model.columns])


def _columns_and_units(effect: Effect, robot: Robot, motion: Signals) -> Iterator[str]:
    columns = effect.columns(robot)
    if len({column.name for column in columns}) < len(columns):
        yield "two of its columns have one name; expected a name for each"
    for column in columns:
        if not (column.unit and column.effect == effect.name and 1 <= column.joint <= robot.n):
            yield f"column {column}; expected a unit, the effect's name {effect.name!r}, and a joint from 1 to {robot.n}"
    if effect.nominal(robot).shape != (len(columns),):
        yield f"nominal has shape {effect.nominal(robot).shape}, expected ({len(columns)},)"
    if effect.name != "rigid_body" and not (effect.signature and effect.mistaken_for):
        yield "no signature or mistaken_for; expected a sentence for reports and for rivals"


def _values_of_the_motion(effect: Effect, robot: Robot, motion: Signals) -> Iterator[str]:
    pattern, values = effect.pattern(robot), effect.values(robot, motion)
    expected = (len(pattern), len(motion.time))
    if values.shape != expected:
        yield f"values have shape {values.shape}, expected {expected}: a row for each entry of pattern"
        return
    if not (np.abs(values) < LARGEST).all():
        yield f"values on a random motion are not finite or larger than {LARGEST:g}"
    if effect.pointwise and effect.scope is Scope.JOINT and not values.any():
        yield "values are zero along a whole random motion"
    if len({tuple(entry) for entry in pattern.tolist()}) < len(pattern):
        yield "pattern names an entry twice"
    still = replace(random_motion(robot, 0), **{key: np.zeros_like(motion.q) for key in "qva"})
    if not np.isfinite(effect.regressor(robot, Model.nominal(robot).refer(still))).all():
        yield "values are not finite at standstill"


def _one_instant_at_a_time(effect: Effect, robot: Robot, motion: Signals) -> Iterator[str]:
    if not effect.pointwise:
        return
    whole = effect.values(robot, motion)
    alone = np.hstack([effect.values(robot, motion.part(slice(k, k + 1))) for k in range(PART.start, PART.stop)])
    if not np.allclose(alone, whole[:, PART], rtol=CLOSE, atol=CLOSE):
        yield "values of an instant depend on others; expected the same alone, or pointwise = False"
    if effect.acts_on == "plant" and not effect.state_size(robot):
        simulated = effect.torque_at(robot, motion, np.zeros((0, len(motion.time))), motion.from_model("load"))
        if not np.allclose(simulated, whole, rtol=CLOSE, atol=CLOSE):
            yield "torque_at, which a simulation asks for, is not values"


def _parts_of_the_arm(effect: Effect, robot: Robot, motion: Signals) -> Iterator[str]:
    if effect.scope is not Scope.JOINT or effect.joints is not None:
        return
    some = replace(effect, joints=(robot.n,))
    chosen = [i for i, column in enumerate(effect.columns(robot)) if column.joint == robot.n]
    whole = effect.regressor(robot, motion)[:, :, chosen]
    if not np.array_equal(some.regressor(robot, motion), whole):
        yield f"on joint {robot.n} alone it is not that part of the effect on all joints"


def _energy(effect: Effect, robot: Robot, motion: Signals) -> Iterator[str]:
    if not effect.passive:
        return
    torque = effect.regressor(robot, motion) @ np.ones(len(effect.columns(robot)))
    if (torque * motion.v < -CLOSE).any():
        yield "passive, but with positive parameters it drives a joint; expected torque * v >= 0"


def _text_in_a_file(effect: Effect, robot: Robot, motion: Signals) -> Iterator[str]:
    settings = json.loads(json.dumps(effect.as_dict()))
    fields = {key: _tuples(value) for key, value in settings.items() if key not in ORIGIN}
    if type(effect)(**fields) != effect:
        yield "it is another effect after it was written to a file and read; expected fields of numbers, texts and tuples of them"
    hash(effect)


def _search(effect: Effect, robot: Robot, motion: Signals) -> Iterator[str]:
    cls = type(effect)
    if cls.detection is not Detection.BY_PLACE:
        return
    for place in cls.places(robot):
        if not cls.search_options(robot, place, [motion]):
            yield f"search_options gives nothing to try on {place}"


def _numpy_source(effect: Effect, robot: Robot, motion: Signals) -> Iterator[str]:
    theta = np.random.default_rng(3).uniform(0.5, 2.0, len(effect.columns(robot)))
    source = effect.numpy_source(robot, theta)
    if source is None or effect.advance:
        return
    known = {key: getattr(motion, key) for key in ("q", "v", "a", "load", "motor")}
    known["t"] = (motion.time - motion.origin)[:, None]
    found = eval(source, {"np": np}, known)
    if not np.allclose(found, effect.regressor(robot, motion) @ theta, rtol=CLOSE, atol=CLOSE):
        yield "formulas, which are exported, are not values"


def _tuples(value: Any) -> Any:
    return tuple(_tuples(one) for one in value) if isinstance(value, list) else value


CLAUSES = (
    _columns_and_units,
    _values_of_the_motion,
    _one_instant_at_a_time,
    _parts_of_the_arm,
    _energy,
    _text_in_a_file,
    _search,
    _numpy_source,
)
