"""Friction that falls as an arm warms up, within a recording or from one day to another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from physident.dynamics.dry_sign import SMOOTH_SIGN_SOURCE, sign_of_velocity
from physident.effects.classification import (
    Family,
    ShapeParameter,
    Variable,
)
from physident.effects.effect import Array, Column, Effect
from physident.errors import InputError
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

NOTICEABLE_WARMING = 1.0  # K: a temperature that changes by less explains nothing


@dataclass(frozen=True)
class WarmUp(Effect):
    """tau_j = (Wc_j sgn v_j + Wv_j v_j) w, with w = exp(-t / T) over a recording's time t, or w = temperature - T0.

    Wc in N m, Wv in N m s/rad: the additional friction of a cold joint, which fades with ``time_constant`` T [s]. Time
    starts with each recording and includes its gaps. Where ``reference_temperature`` T0 [degC] is given, Wc and Wv are per
    degC instead and recordings need a temperature channel. Source: Bittencourt and Gunnarsson, "Static friction in a
    robot joint - modeling and identification of load and temperature effects" (2012), sec. 4.
    """

    time_constant: tuple[float, ...] | None = None
    reference_temperature: float | None = None

    name: ClassVar[str] = "warm_up"
    unit: ClassVar[str] = "N m, N m s/rad"
    family: ClassVar[Family] = Family.FRICTION
    variable: ClassVar[Variable | None] = "time"
    dry: ClassVar[bool] = True
    shape_parameters: ClassVar = (
        ShapeParameter("time_constant", "s", (3.0, 6.0, 12.0, 30.0, 100.0, 300.0), bounded="first"),
    )  # no gear warms within seconds
    formulas: ClassVar[tuple[str, ...]] = (
        f"{SMOOTH_SIGN_SOURCE} * np.exp(-t / {{time_constant}})",
        "v * np.exp(-t / {time_constant})",
    )
    signature: ClassVar[str] = "friction drifts slowly"
    mistaken_for: ClassVar[str] = "a change between sessions: record the same motion again later in the same session"

    def columns(self, robot: Robot) -> tuple[Column, ...]:
        per = "" if self.reference_temperature is None else "/degC"
        kinds = (("coulomb", f"N m{per}"), ("viscous", f"N m s/rad{per}"))
        return tuple(
            Column(f"{self.name}_{kind}_{j + 1}", robot.joints[j].unit(unit), j + 1, self.name)
            for j in self.active(robot)
            for kind, unit in kinds
        )

    @classmethod
    def search_options(cls, robot: Robot, joints: tuple[int, ...], signals: Sequence[Signals]) -> Sequence[Self]:
        """Time constants up to the longest recording, and the measured temperature where it changes.

        Warming that takes longer than every recording is a constant friction in each of them.
        """
        longest = max(float(recording.time[-1] - recording.time[0]) for recording in signals)
        every = list(super().search_options(robot, joints, signals))
        options = [effect for effect in every if effect.time_constant and effect.time_constant[0] <= longest] or every[
            :1
        ]
        temperatures = [recording.temperature for recording in signals if recording.temperature is not None]
        if len(temperatures) == len(signals) and all(is_warming(temperature) for temperature in temperatures):
            start = float(np.mean([temperature[0].mean() for temperature in temperatures]))
            options.append(replace(cls(joints), reference_temperature=round(start, 1)))
        return options

    def numpy_source(self, robot: Robot, theta: Array) -> str | None:
        """None where it follows a measured temperature, which is no argument of the exported function."""
        return None if self.reference_temperature is not None else super().numpy_source(robot, theta)

    def values(self, robot: Robot, signals: Signals) -> Array:
        active = self.active(robot)
        if self.reference_temperature is None:
            weight = np.exp(-(signals.time - signals.origin) / self.shape_values(robot, "time_constant")[:, None])
        elif signals.temperature is None:
            raise InputError(
                f"{signals.source} has no temperature channel; warm_up with a reference temperature needs temperature_1.. [degC] (in a simulation: sensors with temperature)"
            )
        else:
            weight = signals.temperature.T[active] - self.reference_temperature
        v = signals.v.T[active]
        return np.stack([weight * sign_of_velocity(signals, active), weight * v], axis=1).reshape(-1, len(signals.time))


def is_warming(temperature: Array) -> bool:
    """Whether any of the joints' temperatures (N, n) [degC] changes enough to explain a change of friction."""
    return bool(np.ptp(temperature, axis=0).max() > NOTICEABLE_WARMING)
