"""The base class of all effects: columns of a regressor, with their names, units and cones."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, ClassVar, Literal, Self, final

import numpy as np
from numpy.typing import NDArray

from physident.arguments import refuse_one_number
from physident.effects.classification import (
    AddedInertia,
    Column,
    Cone,
    Detection,
    Family,
    JointTerm,
    Scope,
    ShapeParameter,
    Variable,
)
from physident.errors import InputError
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Effect(ABC):
    """A physical effect: torque that is linear in its parameters, tau = Phi(q, v, a) theta.

    ``joints`` (from 1) restricts it to some joints, None for all. A subclass states ``name``, ``unit`` and ``family`` and implements
    ``values``; other members have defaults for one parameter a joint. Raises InputError for ``joints`` of the whole arm or a number."""

    joints: tuple[int, ...] | None = None
    name: ClassVar[str]
    unit: ClassVar[str]
    family: ClassVar[Family]
    label: ClassVar[str] = ""  # its name in a sentence, where that is not ``name`` with spaces
    signature: ClassVar[str] = ""  # how it shows in recordings
    mistaken_for: ClassVar[str] = ""  # the effects it is confused with, and what separates them
    acts_on: ClassVar[Literal["plant", "measurement", "sensor"]] = "plant"
    scope: ClassVar[Scope] = Scope.JOINT
    detection: ClassVar[Detection] = Detection.BY_PLACE
    shape_parameters: ClassVar[tuple[ShapeParameter, ...]] = ()
    needs_temperature: ClassVar[bool] = False  # recordings must have a temperature channel
    needs_torque_sensor: ClassVar[bool] = False  # torques that were computed from motor currents cannot have it
    pointwise: ClassVar[bool] = True  # the value at a sample depends on that sample alone
    settings_by_joint: ClassVar[tuple[str, ...]] = ()  # besides shape parameters, with one value or one a joint
    dry: ClassVar[bool] = False  # its torque follows the sign of a velocity
    passive: ClassVar[bool] = False  # with parameters that are not negative it takes energy at every velocity
    variable: ClassVar[Variable | None] = None  # the one quantity of its joint that its torque is a function of
    goes_with: ClassVar[str] = ""  # an effect of its joint, as the offset of a spring that is relaxed anywhere
    has_prior: ClassVar[bool] = False  # a prior decides what recordings leave open: no parameter is one in a sum only
    origin: ClassVar[str] = ""  # where it was brought from: a file or a package of the user's own
    origin_sha256: ClassVar[str] = ""  # of that file
    needs_model: ClassVar[bool] = False  # the columns depend on the model's own torque or link parameters
    within_model: ClassVar[bool] = False  # it changes what every model has, so that a refitted one takes it up
    # NumPy torque of a unit of each parameter of a joint, in q, v, a, ``load`` (links, gravity), ``motor`` (all but the
    # measurement's effects), time ``t``, state ``z`` and {field}s; ``advance`` is z after a step ``dt`` at the velocity v
    formulas: ClassVar[tuple[str, ...]] = ()
    advance: ClassVar[str] = ""

    def __post_init__(self) -> None:
        shapes = {shape.field: getattr(self, shape.field) for shape in self.shape_parameters}
        refuse_one_number(self.name, joints=self.joints, **shapes)
        if self.scope is Scope.WHOLE_ARM and self.joints is not None:
            raise InputError(f"{self.name} acts on the whole arm but joints are {self.joints}; leave joints out")

    def active(self, robot: Robot) -> list[int]:
        """Indices (from 0) of the joints it acts on; raises InputError for a joint that the robot does not have."""
        if self.joints is None:
            return list(range(robot.n))
        for joint in self.joints:
            if not 1 <= joint <= robot.n:
                raise InputError(f"{self.name}: joint {joint} does not exist, expected 1 to {robot.n}")
        return [joint - 1 for joint in self.joints]

    def columns(self, robot: Robot) -> tuple[Column, ...]:
        """Names and units of its k parameters."""
        some = [(j + 1, robot.joints[j].unit(self.unit)) for j in self.active(robot)]
        return tuple(Column(f"{self.name}_{joint}", unit, joint, self.name) for joint, unit in some)

    def pattern(self, robot: Robot) -> NDArray[np.intp]:
        """Joint row and column (from 0) of each structural non-zero (E, 2), in the order of ``values``; by default each column acts on its joint alone."""
        joint_rows = [column.joint - 1 for column in self.columns(robot)]
        return np.column_stack([joint_rows, np.arange(len(joint_rows))]).astype(np.intp).reshape(-1, 2)

    @abstractmethod
    def values(self, robot: Robot, signals: Signals) -> Array:
        """Structural non-zeros (E, N) of its regressor, in N m (or N) for each unit of the parameter."""

    @final
    def regressor(self, robot: Robot, signals: Signals) -> Array:
        """Regressor (N, n, k): torque [N m|N] for each unit of each parameter."""
        pattern = self.pattern(robot)
        Phi = np.zeros((len(signals.time), robot.n, len(self.columns(robot))))
        Phi[:, pattern[:, 0], pattern[:, 1]] = self.values(robot, signals).T
        return Phi

    def nominal(self, robot: Robot) -> Array:
        """Parameters (k,) that the robot's description states; zero where it states none."""
        return np.zeros(len(self.columns(robot)))

    @classmethod
    def described(cls, robot: Robot) -> tuple[Effect, ...]:
        """The effect as the robot's description states it; none where the description gives it no size."""
        return (cls(),) if cls.nominal is not Effect.nominal and cls().nominal(robot).any() else ()

    def cones(self, robot: Robot) -> tuple[Cone, ...]:
        """Convex sets that its parameters must lie in to be physical; none by default."""
        return ()

    def friction(self, robot: Robot, speeds: Array) -> Array:
        """Friction (k, S) [N m|N] of each unit of each parameter at speeds (S,) [rad/s|m/s] of its joint, unloaded; zero by default.
        The sum over all effects of a joint must oppose its motion: F(v) v >= 0."""
        return np.zeros((len(self.columns(robot)), len(speeds)))

    @classmethod
    def places(cls, robot: Robot) -> list[tuple[int, ...]]:
        """The places where it can act on a robot, each as joint numbers (from 1); the whole arm has none."""
        return cls.scope.places(robot.n)

    @classmethod
    def can_be_wrong(cls, robot: Robot) -> bool:
        """Whether a diagnosis looks for it on a robot: whether the description can be wrong about it, and nothing else says the same."""
        return True

    def told(self, robot: Robot) -> tuple[tuple[Column, ...], Array]:
        """What a diagnosis tells of its parameters: names and units of r values, and the map (r, k) that makes them of theta."""
        return self.columns(robot), np.eye(len(self.columns(robot)))

    def in_words(self, robot: Robot, theta: Array) -> str:
        """A sentence on what parameters ``theta`` (k,) mean; empty where names, numbers and units say it."""
        return ""

    def change_in_words(self, robot: Robot, theta: Array, before: Array) -> str:
        """The same where a model had ``before`` (k,), zero where it had none; by default what they mean now."""
        return self.in_words(robot, theta)

    # shape parameters and their search

    def shape_values(self, robot: Robot, field: str) -> Array:
        """Values (k,) of a shape parameter for the joints it acts on; raises InputError where they are not given."""
        values = getattr(self, field)
        count = len(self.active(robot))
        if values is None or len(values) not in (1, count):
            given = "not given" if values is None else f"given as {len(values)} values"
            raise InputError(
                f"{self.name}: {field} is {given}, expected {count} values, one for each joint; identify finds them"
            )
        return np.broadcast_to(np.array(values, dtype=float), (count,))

    @classmethod
    def search_grid(cls, robot: Robot, joints: tuple[int, ...], shape: ShapeParameter) -> tuple[float, ...]:
        """Values of a shape parameter that are tried for the effect at one place; lengths and speeds in proportion where it slides."""
        scaled = "rad" in shape.unit and joints
        return tuple(value * robot.joints[joints[0] - 1].radian for value in shape.grid) if scaled else shape.grid

    @classmethod
    def search_options(cls, robot: Robot, joints: tuple[int, ...], signals: Sequence[Signals]) -> Sequence[Self]:
        """The concrete effects that a diagnosis tries at one place: one for each value of its shape parameter."""
        if not cls.shape_parameters:
            return [cls(joints or None)]
        (shape,) = cls.shape_parameters
        return [replace(cls(joints or None), **{shape.field: (x,)}) for x in cls.search_grid(robot, joints, shape)]

    @classmethod
    def options_beside(cls, robot: Robot, present: Sequence[tuple[Effect, Array]]) -> Sequence[Self] | None:
        """What a diagnosis tries where that depends on a model's effects and their parameters (k,); None, the default, for ``search_options``."""
        return None

    def once_sized(self, theta: Array) -> Effect:
        """The effect as it is fitted once a search has found its size ``theta`` (k,); by default itself."""
        return self

    @classmethod
    def at_grid_middle(cls, robot: Robot, joints: tuple[int, ...] | None = None) -> Self:
        """The effect with each shape parameter at the middle of its joint's grid."""
        effect = cls(joints)
        for shape in cls.shape_parameters:
            grids = [cls.search_grid(robot, (j + 1,), shape) for j in effect.active(robot)]
            middle = tuple(grid[len(grid) // 2] for grid in grids)
            effect = replace(effect, **{shape.field: middle[:1] if len({*middle}) == 1 else middle})
        return effect

    # what an effect takes from recordings before it is fitted, and a prior that holds its parameters

    def placed(self, robot: Robot, signals: Sequence[Signals]) -> Effect:
        """The effect with what it takes from the motion of recordings alone, such as the range of a curve; by default itself."""
        return self

    def prior_sizes(self, robot: Robot) -> Array | None:
        """Standard deviations (k,) around zero that a prior gives its parameters; None, the default, where only recordings decide."""
        return None

    def unsettled(self, robot: Robot, signals: Signals) -> NDArray[np.intp] | None:
        """How many samples (n,) at the beginning of a segment have a value that depends on the time before it; None where none have."""
        return None

    def around(self, robot: Robot, signals: Signals, samples: slice) -> slice:
        """The samples of one segment that its values at some samples depend on: the whole segment, unless the effect knows better."""
        return samples if self.pointwise else slice(0, len(signals.time))

    def moved_to_start(self) -> tuple[Effect, float]:
        """The effect with its times moved to the start of any motion, and how long [s] that motion must last."""
        return self, 0.0

    def transition(self, robot: Robot) -> Array | None:
        """Speeds (n,) [rad/s|m/s] over which it lets the sign of dry friction turn; None where it says nothing of it."""
        return None

    def cutoff_needed(self, robot: Robot, signals: Signals) -> float:
        """The lowest cutoff [Hz] of the common filter that lets its torque pass; 0 where any cutoff will do."""
        return 0.0

    # simulation: what the plant does and what the instruments show

    def inertia(self, robot: Robot, theta: Array) -> AddedInertia | None:
        """The inertia it adds to the arm, where its torque with parameters ``theta`` (k,) is inertia's alone; None, the default: ``torque_at``."""
        return None

    def state_size(self, robot: Robot) -> int:
        """Number S of its internal states in a simulated arm, such as one bristle deflection for each joint; they start at zero."""
        return 0

    def state_rate(self, robot: Robot, signals: Signals, state: Array) -> Array:
        """Derivative (S, N) of its internal state (S, N) at N unrelated instants."""
        return np.zeros_like(state)

    def torque_at(self, robot: Robot, signals: Signals, state: Array, load: Array) -> Array:
        """Structural non-zeros (E, N) like ``values``, at N unrelated instants of a simulated arm.

        ``state`` (S, N) is its internal state, ``load`` (N, n) [N m|N] the torque of the links' inertia and gravity. The default is
        ``values``; an effect whose values need the past or another effect's torque overrides it.
        """
        return self.values(robot, signals)

    def measure(self, robot: Robot, theta: Array, signals: Signals) -> Signals:
        """What the instruments of a simulated arm show of the true signals, whose torque (N, n) is that of the drives.

        An effect on the plant changes nothing; any other adds its torque: exact for a torque measurement, of first order for a motion sensor.
        """
        if self.acts_on == "plant" or signals.torque is None:
            return signals
        return replace(signals, torque=signals.torque + self.regressor(robot, signals) @ theta)

    def stepped(self, robot: Robot) -> Effect:
        """The effect as the simulation that the robot's description states computes it, in steps of time."""
        return self

    def numpy_source(self, robot: Robot, theta: Array) -> str | None:
        """Its torque with parameters ``theta`` (k,) as a NumPy expression, see ``formulas``; None where it has none."""
        if not self.formulas:
            return None
        gains = np.zeros((len(self.formulas), robot.n))
        gains[:, self.active(robot)] = theta.reshape(-1, len(self.formulas)).T
        sources = [self._with_settings(robot, formula) for formula in self.formulas]
        return " + ".join(f"{array_source(g)} * ({source})" for g, source in zip(gains, sources, strict=True))

    def advance_source(self, robot: Robot) -> str | None:
        """Its state ``z`` (n,) after a step of ``dt`` [s] as a NumPy expression; None for an effect without a state."""
        return self._with_settings(robot, self.advance) if self.advance else None

    def _with_settings(self, robot: Robot, formula: str) -> str:
        settings: dict[str, Any] = {key: value for key, value in vars(self).items() if isinstance(value, float)}
        for field in (shape.field for shape in self.shape_parameters if f"{{{shape.field}}}" in formula):
            values = np.ones(robot.n)
            values[self.active(robot)] = self.shape_values(robot, field)
            settings[field] = array_source(values)
        return formula.format(**settings)

    def joint_terms(self, robot: Robot, theta: Array) -> tuple[JointTerm, ...] | None:
        """Its torque with parameters ``theta`` (k,) in the terms of a simulator's joints; None where it has none."""
        return None

    def folded(self, robot: Robot, theta: Array) -> tuple[Effect, Array]:
        """The effect and parameters that stand for it in a program without its memory; by default the same ones."""
        return self, theta

    @final
    def as_dict(self) -> dict[str, Any]:
        """Its name and settings, as JSON can hold them."""
        origin = {"from": self.origin, "sha256": self.origin_sha256} if self.origin else {}
        return {"effect": self.name, **origin, **{key: _as_lists(value) for key, value in asdict(self).items()}}


def array_source(values: Array) -> str:
    """Python source of a NumPy array with every digit of its values."""
    return f"np.array({values.tolist()!r})"


def _as_lists(value: Any) -> Any:
    return [_as_lists(v) for v in value] if isinstance(value, tuple) else value
