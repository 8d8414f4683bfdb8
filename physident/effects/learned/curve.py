"""The base class of learned curves: a smooth function of one quantity of a joint, added to its torque."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from physident.arguments import refuse_one_number
from physident.effects.classification import Column, Detection, Family
from physident.effects.effect import Array, Effect, array_source
from physident.effects.learned.range_words import range_in_words
from physident.effects.learned.spline import bumps, mode_count, modes, sizes
from physident.errors import InputError
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

NARROWEST = 1e-3  # of a range, in the unit of its quantity: a joint that hardly moves shows no curve
CEILING = 6.0  # times what a joint leaves without a curve: one that others hide to five sixths is not shown
SHOWN = 200  # points of a printed or drawn curve


@dataclass(frozen=True)
class LearnedCurve(Effect):
    """A sum of smooth functions of one quantity x of the joint, from ``low`` to ``high``; beyond, a constant or nearly.

    Its parameters are the sizes of the functions, from the smoothest on, with the prior of a smoothing spline: each is zero with the
    standard deviation ``amplitude`` [N m|N], or with less where the root mean square of its torque would exceed ``ceiling`` [N m|N]: a
    curve that hardly bends is also gravity's, and the two must not grow against each other. ``low``, ``high``, ``amplitude`` and
    ``ceiling`` are one value or one a joint; ``identify`` takes the range from the recordings, the amplitude from how well rows that
    were left out are predicted, and the ceiling from what is left without curves. Where a curve ``has_mean``, its
    first function is a constant; of two that explain the same, an effect of the catalogue costs nothing and a curve does.
    Raises InputError for settings of a wrong length, ends in the wrong order, and an amplitude or a ceiling that is not positive.
    """

    low: tuple[float, ...] | None = None
    high: tuple[float, ...] | None = None
    amplitude: tuple[float, ...] | None = None
    ceiling: tuple[float, ...] | None = None

    unit: ClassVar[str] = "N m"
    family: ClassVar[Family] = Family.LEARNED
    detection: ClassVar[Detection] = Detection.AFTER_LAWS
    has_prior: ClassVar[bool] = True
    settings_by_joint: ClassVar[tuple[str, ...]] = ("low", "high", "amplitude", "ceiling")
    channel: ClassVar[str] = "the model's load, expected signals from Model.refer"  # without which it has no quantity
    is_held: ClassVar[bool] = True  # by a ceiling
    pieces: ClassVar[int] = 32  # of its splines: what is narrower than two of them is not seen
    quantity_unit: ClassVar[str] = "rad"
    middle: ClassVar[tuple[float, float]] = (-1.0, 1.0)  # a range where no recordings give one

    def __post_init__(self) -> None:
        super().__post_init__()
        refuse_one_number(self.name, **{name: getattr(self, name) for name in self.settings_by_joint})
        counts = {name: len(given) for name in self.settings_by_joint if (given := getattr(self, name)) is not None}
        joints = max(counts.values(), default=1) if self.joints is None else len(self.joints)
        for name, count in counts.items():
            if count not in (1, joints):
                raise InputError(f"{self.name}: {name} has {count} values, expected one, or {joints}, one a joint")
        if (self.low is None) != (self.high is None):
            raise InputError(f"{self.name}: low is {self.low} and high is {self.high}, expected both or neither")
        ends = np.array(self.low or (0.0,)), np.array(self.high or (1.0,))
        if not (np.isfinite([*ends[0], *ends[1]]).all() and (ends[0] < ends[1]).all()):
            raise InputError(
                f"{self.name}: low is {self.low} and high is {self.high}, expected low below high, both finite"
            )
        for name in ("amplitude", "ceiling"):
            given = getattr(self, name)
            if given is not None and not (np.isfinite(given).all() and min(given) > 0):
                raise InputError(f"{self.name}: {name} is {given}, expected positive numbers [N m|N]")

    @abstractmethod
    def quantity(self, signals: Signals) -> Array | None:
        """What the curve is a function of (N, n), None where signals do not have it."""

    @abstractmethod
    def quantity_source(self, robot: Robot) -> str:
        """The same as a NumPy expression."""

    @classmethod
    def is_shown(cls, signals: Sequence[Signals], joint: int) -> bool:
        """Whether recordings show enough of its quantity on a joint (index) for a diagnosis to try it."""
        return True

    @property
    def has_mean(self) -> bool:
        """Whether a constant is one of its functions."""
        return True

    def zeros(self, robot: Robot) -> Array | None:
        """The quantity (k,) at which the curve of each joint is zero, whatever its parameters; None where nothing is demanded."""
        return None

    def weight(self, signals: Signals, joints: Sequence[int]) -> Array:
        """What the curve of each of some joints is multiplied by (k, N)."""
        return np.ones((len(joints), len(signals.time)))

    def scale(self, x: Array, low: Array, high: Array) -> Array:
        """The place of quantities (k, N) on a scale from 0 to 1 between ``low`` and ``high`` (k, 1), monotone."""
        return (np.clip(x, low, high) - low) / (high - low)

    def circles(self, robot: Robot) -> NDArray[np.bool_]:
        """Which of its joints (k,) turn freely, so that their curve repeats with each turn."""
        return np.zeros(len(self.active(robot)), dtype=bool)

    # what every effect states

    def columns(self, robot: Robot) -> tuple[Column, ...]:
        return tuple(
            Column(f"{self.name}_{i + 1}_{j + 1}", robot.joints[j].unit(self.unit), j + 1, self.name)
            for j in self.active(robot)
            for i in range(self._count)
        )

    def values(self, robot: Robot, signals: Signals) -> Array:
        return self._values(robot, signals, self._quantity(signals))

    def _quantity(self, signals: Signals) -> Array:
        x = self.quantity(signals)
        if x is None:
            raise InputError(f"{signals.source}: {self.name} needs {self.channel}")
        return x

    def _values(self, robot: Robot, signals: Signals, x: Array) -> Array:
        joints = self.active(robot)
        shapes = self._shapes(robot, x.T[joints])
        return (shapes * self.weight(signals, joints)[:, None, :]).reshape(-1, x.shape[0])

    def _shapes(self, robot: Robot, x: Array) -> Array:
        """Values (k, modes, N) of every mode at quantities x (k, N), less those where the curve is zero."""
        zeros = self.zeros(robot)
        shapes = self._free_shapes(robot, x)
        return shapes if zeros is None else shapes - self._free_shapes(robot, zeros[:, None])

    def _free_shapes(self, robot: Robot, x: Array) -> Array:
        low, high = (self.shape_values(robot, field)[:, None] for field in ("low", "high"))
        place = self.pieces * self.scale(x, low, high)
        circles = self.circles(robot)
        if circles.any():
            turned = np.arctan2(np.sin(x), np.cos(x))
            place = np.where(circles[:, None], self.pieces * (turned / (2 * np.pi) + 0.5), place)
        return np.stack([self._modes(bool(c)).T @ bumps(p, self.pieces) for p, c in zip(place, circles, strict=True)])

    @property
    def _count(self) -> int:
        return mode_count(self.pieces) - (not self.has_mean)

    def _modes(self, circle: bool) -> Array:
        """Coefficients (pieces + 3, modes) of the B-splines in each of its modes."""
        return modes(self.pieces, circle)[:, not self.has_mean :]

    def prior_sizes(self, robot: Robot) -> Array | None:
        amplitude = self.shape_values(robot, "amplitude")
        ceiling = np.full(len(amplitude), np.inf) if self.ceiling is None else self.shape_values(robot, "ceiling")
        return self._sizes(amplitude, ceiling).ravel()

    def prior_sizes_of_one(self) -> Array:
        """Standard deviations (modes,) [N m|N] of the prior of a curve on one joint; raises InputError where it has no amplitude."""
        if self.amplitude is None:
            raise InputError(f"{self.name}: amplitude is not given, expected one value; identify finds it")
        return self._sizes(np.array(self.amplitude[:1]), np.array((self.ceiling or (np.inf,))[:1]))[0]

    def _sizes(self, amplitude: Array, ceiling: Array) -> Array:
        """Standard deviations (k, modes) [N m|N] of the numbers of curves with amplitudes and ceilings (k,)."""
        return np.minimum(amplitude[:, None], ceiling[:, None] / sizes(self.pieces)[not self.has_mean :])

    def beside(self, left: Sequence[float]) -> Self:
        """The curve with the ceiling that goes with what its joints have ``left`` (k,) [N m|N] without it, unless it has one or needs
        none."""
        if self.ceiling is not None or not self.is_held:
            return self
        return replace(self, ceiling=tuple(CEILING * one for one in left))

    def placed(self, robot: Robot, signals: Sequence[Signals]) -> Effect:
        """The curve with the range of its quantity in recordings, where none is given."""
        if self.low is not None and self.high is not None:
            return self
        ranges = [self._range(robot, j, signals) for j in self.active(robot)]
        return replace(self, low=tuple(r[0] for r in ranges), high=tuple(r[1] for r in ranges))

    def was_learned(self, robot: Robot, signals: Signals) -> NDArray[np.bool_]:
        """Where the quantity of signals (N, n) lies in the range of its joint's curve, and everywhere on joints without one; beyond, the
        curve is a guess. Raises InputError where signals do not have the quantity."""
        result = np.ones(signals.q.shape, dtype=bool)
        x = self._quantity(signals)
        for k, j in enumerate(self.active(robot)):
            low, high = self.ends(robot, k)
            result[:, j] = self.circles(robot)[k] | ((x[:, j] >= low) & (x[:, j] <= high))
        return result

    def _range(self, robot: Robot, joint: int, signals: Sequence[Signals]) -> tuple[float, float]:
        found = [x[:, joint] for one in signals if (x := self.quantity(one)) is not None and len(x)]
        if not found:
            return self.middle
        low, high = float(min(x.min() for x in found)), float(max(x.max() for x in found))
        return (low, high) if high - low > NARROWEST else (low - NARROWEST, high + NARROWEST)

    @classmethod
    def search_options(cls, robot: Robot, joints: tuple[int, ...], signals: Sequence[Signals]) -> Sequence[Self]:
        return [replace(cls(joints).placed(robot, signals), amplitude=(1.0,))]  # pyright: ignore[reportReturnType]

    @classmethod
    def at_grid_middle(cls, robot: Robot, joints: tuple[int, ...] | None = None) -> Self:
        low, high = cls.middle
        return cls(joints, (low,), (high,), (1.0,))

    # what a curve looks like

    def curve(self, robot: Robot, theta: Array, k: int = 0) -> tuple[Array, Array, Array]:
        """Points x (S,) of its k-th joint's range, its torque there (S,) [N m|N] for parameters (k modes,), and the modes (S, modes)."""
        x = np.linspace(*self.ends(robot, k), SHOWN)
        count = len(self.active(robot))
        Phi = self._shapes(robot, np.tile(x, (count, 1)))[k].T
        return x, Phi @ theta.reshape(count, -1)[k], Phi

    def shapes_at(self, robot: Robot, x: Array) -> Array:
        """Values (S, modes) of the modes of a curve on one joint, at points x (S,) of its quantity."""
        return self._shapes(robot, x[None])[0].T

    def of_joint(self, robot: Robot, k: int) -> Self:
        """The curve of its k-th joint alone."""
        own = {
            f: (float(self.shape_values(robot, f)[k]),) for f in self.settings_by_joint if getattr(self, f) is not None
        }
        return replace(self, joints=(int(self.active(robot)[k]) + 1,), **own)

    def ends(self, robot: Robot, k: int = 0) -> tuple[float, float]:
        """Lower and upper end of the range of its k-th joint."""
        if self.circles(robot)[k]:
            return -np.pi, np.pi
        return float(self.shape_values(robot, "low")[k]), float(self.shape_values(robot, "high")[k])

    def unit_of_quantity(self, robot: Robot, joint: int) -> str:
        """The unit of its quantity on a joint (index), which may be prismatic."""
        return robot.joints[joint].unit(self.quantity_unit)

    def in_words(self, robot: Robot, theta: Array) -> str:
        """Where the curve of each joint is largest, for the sizes of its functions say nothing."""
        curves = [self.curve(robot, theta, k)[:2] for k in range(len(self.active(robot)))]
        return "; ".join(self.points_in_words(robot, k, *curve) for k, curve in enumerate(curves)) + "."

    def points_in_words(self, robot: Robot, k: int, x: Array, torque: Array, top: int | None = None) -> str:
        """What the curve of its k-th joint is at the ``top`` of some ascending points (S,), by default where it is largest, and between which of
        them it is at least half of that."""
        j, top = self.active(robot)[k], int(np.argmax(np.abs(torque))) if top is None else top
        inside = torque * np.sign(torque[top]) >= np.abs(torque[top]) / 2
        first = top - int(np.argmin(inside[top::-1])) + 1 if not inside[: top + 1].all() else 0
        last = top + int(np.argmin(inside[top:])) - 1 if not inside[top:].all() else len(x) - 1
        unit = robot.joints[j].unit(self.unit)
        where = f"{range_in_words(float(x[first]), float(x[last]))} {self.unit_of_quantity(robot, j)}"
        return f"joint {j + 1}: a torque that depends on {self.dependence}, {torque[top]:+.2g} {unit} {where}"

    dependence: ClassVar[str] = "position"  # its quantity, in a sentence

    # export

    def numpy_source(self, robot: Robot, theta: Array) -> str | None:
        """The splines one by one, so that the source is the torque in NumPy, C and CasADi."""
        joints, circles = self.active(robot), self.circles(robot)
        values = theta.reshape(len(joints), -1)
        count = self.pieces + 3
        C = np.zeros((count, robot.n))
        for j, c, own in zip(joints, circles, values, strict=True):
            C[:, j] = self._modes(bool(c)) @ own
        if (zeros := self.zeros(robot)) is not None:  # the splines add up to one everywhere
            C[:, joints] -= np.einsum("kmn,km->k", self._free_shapes(robot, zeros[:, None]), values)
        place = self._place_source(robot, circles)
        bump = "((np.maximum(2 - np.abs({t}), 0) ** 3 - 4 * np.maximum(1 - np.abs({t}), 0) ** 3) / 6)"
        terms = [f"{array_source(c)} * {bump.format(t=f'({place} - {i - 1})')}" for i, c in enumerate(C)]
        total = " + ".join(terms)
        factor = self.factor_source(robot)
        return f"{factor} * ({total})" if factor else f"({total})"

    def factor_source(self, robot: Robot) -> str:
        """What its curve is multiplied by, as a NumPy expression; empty where that is one."""
        return ""

    def _place_source(self, robot: Robot, circles: NDArray[np.bool_]) -> str:
        """Where its quantity lies among the splines, joint by joint."""
        joints = self.active(robot)
        low, high, circle = np.zeros(robot.n), np.ones(robot.n), np.zeros(robot.n)
        low[joints], high[joints], circle[joints] = (
            self.shape_values(robot, "low"),
            self.shape_values(robot, "high"),
            circles,
        )
        source = f"{self.pieces} * {self.scale_source(self.quantity_source(robot), low, high)}"
        if circles.any():
            turned = f"{self.pieces} * (np.arctan2(np.sin(q), np.cos(q)) / {2 * np.pi} + 0.5)"
            source = f"({array_source(1 - circle)} * {source} + {array_source(circle)} * {turned})"
        return source

    def scale_source(self, x: str, low: Array, high: Array) -> str:
        """``scale`` as a NumPy expression."""
        width = array_source(1 / (high - low))
        return f"((np.minimum(np.maximum({x}, {array_source(low)}), {array_source(high)}) - {array_source(low)}) * {width})"
