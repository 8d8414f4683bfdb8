"""Two rival effects beside a model: their columns on each joint, at several shapes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from physident.dynamics.model import Model
from physident.effects.catalogue import CATALOGUE
from physident.effects.classification import Detection, Scope
from physident.effects.effect import Effect
from physident.effects.payload import LinkChange
from physident.errors import InputError
from physident.excitation.criterion.separation import Separation, Term
from physident.excitation.task import Task, sized
from physident.identifiability.base_parameters import find_base_parameters
from physident.robots.robot import Robot

SHAPES = 3  # of an effect's grid: its quarters


@dataclass(frozen=True, eq=False)
class Rivals:
    """Effects ``a`` and ``b`` on ``joints`` (from 1), the model ``without`` them there, and each one's ``options``: the
    effect on all its joints at one shape. The model is refitted beside them, or ``held`` where it holds one of them whole."""

    a: str
    b: str
    joints: tuple[int, ...]
    without: Model
    options: tuple[tuple[Effect, ...], tuple[Effect, ...]]

    @property
    def held(self) -> bool:
        """A change of a link lies inside a rigid body that is refitted: only beside a model that stays does it show."""
        return any(issubclass(CATALOGUE[name], LinkChange) for name in (self.a, self.b))

    @property
    def refitted(self) -> tuple[Effect, ...]:
        """The effects that may take up a rival's torque."""
        return () if self.held else self.without.effects

    def on(self, name: str, joint: int) -> list[Effect]:
        """The options of one of the two on one joint."""
        every = self.options[0] if name == self.a else self.options[1]
        if CATALOGUE[name].scope is Scope.WHOLE_ARM:
            return list(every)
        place = _place(name, joint, self.without.robot.n)
        return [replace(effect, joints=place, **_shape_at(effect, joint)) for effect in every]


def rivals_of(model: Model, a: str, b: str, joint: int | None = None) -> Rivals:
    """The rivals on one joint, or on every joint where both can be. Raises InputError for an effect that is unknown or no
    matter of a motion, for one and the same, and for a joint that one of them cannot be on."""
    for name in (a, b):
        if name not in CATALOGUE or CATALOGUE[name].detection is not Detection.BY_PLACE:
            known = ", ".join(known for known, cls in CATALOGUE.items() if cls.detection is Detection.BY_PLACE)
            raise InputError(f"effect {name!r} cannot be told apart by a motion, expected one of {known}")
    if a == b:
        raise InputError(f"effect {a!r} was given twice, expected two rivals")
    n = model.robot.n
    can = [j for j in range(1, n + 1) if all(_place(name, j, n) is not None for name in (a, b))]
    if not can:
        raise InputError(
            f"robot {model.robot.name} has no joint for {a} beside {b}, expected rivals that need fewer joints"
        )
    if joint is not None and joint not in can:
        raise InputError(f"joint {joint} has no {a} beside {b}, expected one of {', '.join(map(str, can))}")
    joints = tuple(can) if joint is None else (joint,)
    without = _without(model, (a, b), joints)
    options = tuple(_options(model, name, joints) for name in (a, b))
    return Rivals(a, b, joints, without, options)  # pyright: ignore[reportArgumentType]


def task_of_rivals(rivals: Rivals, task: Task) -> tuple[Task, Separation]:
    """The columns of a motion that tells rivals apart, and its criterion; rows are weighted as in a ``task``."""
    robot, model = rivals.without.robot, rivals.without
    independent = np.zeros(0, dtype=np.intp) if rivals.held else find_base_parameters(robot, model.effects).independent
    effects = [*model.effects, *rivals.options[0], *rivals.options[1]]
    at = len(model.columns)
    places: list[dict[int, list[tuple[int, ...]]]] = []
    for options in rivals.options:
        place: dict[int, list[tuple[int, ...]]] = {}
        for effect in options:
            columns = effect.columns(robot)
            for joint in rivals.joints:
                whole = effect.scope is Scope.WHOLE_ARM
                own = tuple(at + k for k, c in enumerate(columns) if whole or c.joint == joint)
                place.setdefault(joint, []).append(own)
            at += len(columns)
        places.append(place)
    extra = list(range(len(model.columns), at))
    chosen = np.array([*independent, *extra], dtype=np.intp)
    position = {c: k for k, c in enumerate(extra)}
    terms = []
    for joint in rivals.joints:
        for one, other in ((places[0], places[1]), (places[1], places[0])):
            beside = tuple(sorted({position[c] for option in other[joint] for c in option}))
            terms += [Term(tuple(position[c] for c in own), beside) for own in one[joint]]
    plain = Task(model, tuple(effects), chosen, np.ones(len(chosen)), task.weights, task.weighting)
    return sized(plain), Separation(len(independent), tuple(terms))


def _place(name: str, joint: int, n: int) -> tuple[int, ...] | None:
    """The place of an effect that begins at a joint (from 1) of n, the whole arm for any joint; None where it has none."""
    return next((place for place in CATALOGUE[name].scope.places(n) if place[:1] in ((), (joint,))), None)


def _options(model: Model, name: str, joints: tuple[int, ...]) -> tuple[Effect, ...]:
    """The effect on its joints: as the model has it, or at some shapes of its grid."""
    cls = CATALOGUE[name]
    where = None if cls.scope is Scope.WHOLE_ARM else joints
    if cls.scope is Scope.NEIGHBOURS:
        return tuple(cls(joints=_place(name, joint, model.robot.n)) for joint in joints)
    own = [effect for effect in model.effects if effect.name == name]
    if own and not cls.shape_parameters:
        return (replace(own[0], joints=where),)
    if not cls.shape_parameters:
        return (cls(joints=where),)
    (shape,) = cls.shape_parameters
    quarters = [shape.grid[round(k * (len(shape.grid) - 1) / (SHAPES + 1))] for k in range(1, SHAPES + 1)]
    return tuple(cls(joints=where, **{shape.field: (value,) * len(joints)}) for value in quarters)


def _shape_at(effect: Effect, joint: int) -> dict[str, tuple[float, ...]]:
    """The shape values of one of an effect's joints."""
    own = effect.joints or ()
    values = {shape.field: getattr(effect, shape.field) for shape in effect.shape_parameters}
    at = own.index(joint) if joint in own else 0
    return {field: (v[at] if len(v) > 1 else v[0],) for field, v in values.items() if v is not None}


def _without(model: Model, names: tuple[str, str], joints: tuple[int, ...]) -> Model:
    """The model with some effects taken off some joints, values kept."""
    robot, effects, theta, at = model.robot, [], [], 0
    for effect in model.effects:
        columns = effect.columns(robot)
        own = model.theta[at : at + len(columns)]
        at += len(columns)
        if effect.name not in names:
            effects.append(effect)
            theta.append(own)
            continue
        left = [j for j in (effect.joints or range(1, robot.n + 1)) if j not in joints]
        if left and effect.scope is not Scope.WHOLE_ARM:
            shapes = {
                s.field: tuple(_shape_at(effect, j)[s.field][0] for j in left)
                for s in effect.shape_parameters
                if getattr(effect, s.field)
            }
            effects.append(replace(effect, joints=tuple(left), **shapes))
            theta.append(own[[k for k, c in enumerate(columns) if c.joint in left]])
    return Model(robot, tuple(effects), np.concatenate(theta))


def arm_of(source: Robot | Model) -> Model:
    """The model itself, or a robot's nominal one with the default effects."""
    return Model.nominal(source) if isinstance(source, Robot) else source
