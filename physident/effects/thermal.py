"""Friction that falls as an arm warms up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.effects.effect import Array, Column, Effect, Shape
from physident.effects.friction import smooth_sign
from physident.errors import InputError
from physident.recordings.signals import Signals
from physident.robots.robot import Robot


@dataclass(frozen=True)
class WarmUp(Effect):
    """tau_j = (Wc_j sgn v_j + Wv_j v_j) w, with w = exp(-t / T) over a recording's time t, or w = temperature - T0.

    Wc in N m, Wv in N m s/rad: the friction that a cold joint has more; per degC where ``reference_temperature`` T0
    [degC] is given, which needs a temperature channel. ``time_constant`` T [s]. t starts with each recording and runs on
    over its gaps. Source: Bittencourt and Gunnarsson, "Static friction in a robot joint - modeling and identification
    of load and temperature effects" (2012), sec. 4.
    """

    time_constant: tuple[float, ...] | None = None
    reference_temperature: float | None = None

    name: ClassVar[str] = "warm_up"
    unit: ClassVar[str] = "N m, N m s/rad"
    shapes: ClassVar = (Shape("time_constant", "s", (3.0, 6.0, 12.0, 30.0, 100.0, 300.0)),)
    signature: ClassVar[str] = "friction drifts slowly"
    rivals: ClassVar[str] = "a change between sessions: record the same motion again later in the same session"

    def columns(self, robot: Robot) -> tuple[Column, ...]:
        per = "" if self.reference_temperature is None else "/degC"
        kinds = (("coulomb", f"N m{per}"), ("viscous", f"N m s/rad{per}"))
        return tuple(
            Column(f"{self.name}_{kind}_{j + 1}", unit, j + 1, self.name)
            for j in self.active(robot)
            for kind, unit in kinds
        )

    def pattern(self, robot: Robot) -> NDArray[np.intp]:
        rows = np.repeat(self.active(robot), 2)
        return np.column_stack([rows, np.arange(len(rows))]).astype(np.intp)

    def values(self, robot: Robot, signals: Signals) -> Array:
        active = self.active(robot)
        if self.reference_temperature is None:
            weight = np.exp(-(signals.time - signals.origin) / self.shape(robot, "time_constant")[:, None])
        elif signals.temperature is None:
            raise InputError(
                f"{signals.source}: no temperature channel, which warm_up with a reference temperature needs; expected temperature_1.. [degC] (simulate: sensors with temperature), or a model without it"
            )
        else:
            weight = signals.temperature.T[active] - self.reference_temperature
        v = signals.v.T[active]
        return np.stack([weight * smooth_sign(v), weight * v], axis=1).reshape(-1, len(signals.time))
