"""Two rival effects: the model without them, their variants on each joint, and the columns of a motion that separates them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from physident.dynamics.model import Model
from physident.effects.catalogue import CATALOGUE, on_joints
from physident.effects.classification import Detection, Scope
from physident.effects.effect import Effect
from physident.errors import InputError, did_you_mean
from physident.excitation.criterion.separation import Separation, Term
from physident.excitation.task import Task, scaled_to_unit_size
from physident.identifiability.base_parameters import find_base_parameters
from physident.robots.robot import Robot

SHAPE_VALUES = 3  # of an effect's grid of shape values: its quarters


@dataclass(frozen=True, eq=False)
class Rivals:
    """Effects ``a`` and ``b`` on ``joints`` (from 1).

    ``reduced_model`` is the model without them there. ``variants`` lists, for each of the two, the effect on all joints at
    several values of its shape parameter.
    """

    a: str
    b: str
    joints: tuple[int, ...]
    reduced_model: Model
    variants: tuple[tuple[Effect, ...], tuple[Effect, ...]]

    @property
    def model_fixed(self) -> bool:
        """Whether the model is fixed instead of refitted: a refitted one contains any change of a link or of all friction."""
        return any(CATALOGUE[name].within_model for name in (self.a, self.b))

    @property
    def refitted(self) -> tuple[Effect, ...]:
        """The effects of the model that are refitted beside the rivals."""
        return () if self.model_fixed else self.reduced_model.effects

    def on(self, name: str, joint: int) -> list[Effect]:
        """The variants of one of the two effects, on one joint."""
        variants = self.variants[0] if name == self.a else self.variants[1]
        if CATALOGUE[name].scope is Scope.WHOLE_ARM:
            return list(variants)
        place = _place(name, joint, self.reduced_model.robot)
        return [replace(effect, joints=place, **_shape_at(effect, joint)) for effect in variants]


def rivals_of(model: Model, a: str, b: str, joint: int | None = None) -> Rivals:
    """The rivals on one joint, or on every joint that both can act on.

    Raises InputError for an effect that is unknown or that no motion can show, for the same effect twice, and for a joint
    that one of them cannot act on.
    """
    for name in (a, b):
        if name not in CATALOGUE or CATALOGUE[name].detection is not Detection.BY_PLACE:
            known = [known for known, cls in CATALOGUE.items() if cls.detection is Detection.BY_PLACE]
            raise InputError(
                f"effect {name!r} cannot be separated by a motion, expected one of {', '.join(known)}{did_you_mean(name, known)}"
            )
    if a == b:
        raise InputError(f"effect {a!r} was given twice, expected two different effects")
    robot = model.robot
    possible = [j for j in range(1, robot.n + 1) if all(_place(name, j, robot) is not None for name in (a, b))]
    if not possible:
        raise InputError(f"robot {robot.name} has no joint for {a} beside {b}, expected effects that need fewer joints")
    if joint is not None and joint not in possible:
        raise InputError(f"joint {joint} has no {a} beside {b}, expected one of {', '.join(map(str, possible))}")
    joints = tuple(possible) if joint is None else (joint,)
    variants = (_variants(model, a, joints), _variants(model, b, joints))
    return Rivals(a, b, joints, _reduced(model, (a, b), joints), variants)


def task_of_rivals(rivals: Rivals, task: Task) -> tuple[Task, Separation]:
    """The columns of a motion that separates rivals, and its criterion; rows are weighted as in ``task``."""
    model = rivals.reduced_model
    robot, start = model.robot, len(model.columns)
    fixed = rivals.model_fixed
    baseline = np.zeros(0, dtype=np.intp) if fixed else find_base_parameters(robot, model.effects).independent
    # for each rival and joint, the columns of each variant
    columns: list[dict[int, list[tuple[int, ...]]]] = []
    for variants in rivals.variants:
        by_joint: dict[int, list[tuple[int, ...]]] = {joint: [] for joint in rivals.joints}
        for effect in variants:
            described = effect.columns(robot)
            for joint in rivals.joints:
                whole = effect.scope is Scope.WHOLE_ARM
                by_joint[joint].append(tuple(start + k for k, c in enumerate(described) if whole or c.joint == joint))
            start += len(described)
        columns.append(by_joint)
    added = list(range(len(model.columns), start))
    position = {c: k for k, c in enumerate(added)}
    terms = []
    for joint in rivals.joints:
        for effect_columns, rival_columns in ((columns[0], columns[1]), (columns[1], columns[0])):
            rival = tuple(sorted({position[c] for variant in rival_columns[joint] for c in variant}))
            terms += [Term(tuple(position[c] for c in variant), rival) for variant in effect_columns[joint]]
    chosen = np.array([*baseline, *added], dtype=np.intp)
    effects = (*model.effects, *rivals.variants[0], *rivals.variants[1])
    unscaled = Task(model, effects, chosen, np.ones(len(chosen)), task.weights, task.weighting)
    return scaled_to_unit_size(unscaled), Separation(len(baseline), tuple(terms))


def _place(name: str, joint: int, robot: Robot) -> tuple[int, ...] | None:
    """The place of an effect that begins at a joint (from 1) of a robot, the whole arm for any joint; None where it has none."""
    return next((place for place in CATALOGUE[name].places(robot) if place[:1] in ((), (joint,))), None)


def _variants(model: Model, name: str, joints: tuple[int, ...]) -> tuple[Effect, ...]:
    """The effect on its joints: as the model has it, or at several values of its shape parameter."""
    cls = CATALOGUE[name]
    where = None if cls.scope is Scope.WHOLE_ARM else joints
    if cls.scope is Scope.NEIGHBOURS:
        return tuple(cls(joints=_place(name, joint, model.robot)) for joint in joints)
    beside = cls.options_beside(model.robot, model.effect_parameters()) or ()
    if not cls.shape_parameters:
        held = [effect for effect in model.effects if effect.name == name]
        if held and where is not None:
            there = [effect for effect in held if {j - 1 for j in where} <= set(effect.active(model.robot))]
            return (on_joints(there[0], model.robot, where) if there else cls(joints=where),)
        return (held[0] if held else next(iter(beside), cls(joints=where)),)
    (shape,) = cls.shape_parameters
    grids = [cls.search_grid(model.robot, (joint,), shape) for joint in joints]
    quarters = [k / (SHAPE_VALUES + 1) for k in range(1, SHAPE_VALUES + 1)]
    return tuple(
        cls(joints=where, **{shape.field: tuple(g[round(at * (len(g) - 1))] for g in grids)}) for at in quarters
    )


def _shape_at(effect: Effect, joint: int) -> dict[str, tuple[float, ...]]:
    """The values of an effect's shape parameters and settings on one of its joints."""
    joints = effect.joints or ()
    fields = (*(shape.field for shape in effect.shape_parameters), *effect.settings_by_joint)
    values: dict[str, tuple[float, ...]] = {
        field: value for field in fields if isinstance(value := getattr(effect, field), tuple)
    }
    index = joints.index(joint) if joint in joints else 0
    return {field: v[index : index + 1] if len(v) > 1 else v for field, v in values.items()}


def _reduced(model: Model, names: tuple[str, str], joints: tuple[int, ...]) -> Model:
    """The model without some effects on some joints; all other values are kept."""
    robot, effects, theta, start = model.robot, [], [], 0
    for effect in model.effects:
        columns = effect.columns(robot)
        values = model.theta[start : start + len(columns)]
        start += len(columns)
        if effect.name not in names:
            effects.append(effect)
            theta.append(values)
            continue
        kept = [j for j in (effect.joints or range(1, robot.n + 1)) if j not in joints]
        if kept and effect.scope is not Scope.WHOLE_ARM:
            effects.append(on_joints(effect, robot, kept))
            theta.append(values[[k for k, c in enumerate(columns) if c.joint in kept]])
    return Model(robot, tuple(effects), np.concatenate(theta))
