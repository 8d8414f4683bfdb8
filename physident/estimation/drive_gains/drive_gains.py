"""Drive gains: what one ampere of motor current is worth in joint torque, from recordings with and without a known load.

K_j i_j = Y_j theta holds for any common multiple of all gains and parameters: recordings without a known load give
products only. A load of known mass is a torque that is not multiplied by anything unknown, and fixes the scale.
Source: Gautier, Briot, "Global identification of joint drive gains and dynamic parameters of robots" (2014), sec. 3.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.regressor import build_regressor
from physident.effects.catalogue import DEFAULT_EFFECTS, make_effects
from physident.effects.effect import Effect
from physident.errors import InputError
from physident.estimation.drive_gains.equations import GainEquations
from physident.estimation.identify import prepare_moving
from physident.estimation.uncertainty import t_quantile
from physident.identifiability.base_parameters import find_base_parameters
from physident.recordings.checks import refuse_constant, refuse_twice
from physident.recordings.recording import Recording
from physident.recordings.signals import Filter
from physident.robots.inertia import PARAMETER_NAMES
from physident.robots.robot import Robot

Array = NDArray[np.float64]
METHODS = ("tls", "ls", "physical")
HEAVIEST = 10.0  # of the arm's own mass
VAGUE = 0.15  # half-width of a relative interval above which a gain is called vague


@dataclass(frozen=True, eq=False)
class DriveGains:
    """Joint torque for each unit of motor current, ``gains`` (n,) [N m/A], NaN where it cannot be found.

    ``intervals`` (n, 2) hold 95 %; ``covariance`` (n, n) of the gains' logarithms, from ``blocks`` blocks. ``load`` (10,) [kg, kg m, kg m^2] is the
    load in the last link's frame, its mass the given one. ``relative`` (n,) [%] of the current left unexplained.
    """

    method: str
    gains: Array
    intervals: Array
    covariance: Array
    blocks: int
    load: Array
    relative: Array
    recordings: tuple[str, ...]

    @property
    def found(self) -> NDArray[np.bool_]:
        """Which gains (n,) the recordings decide."""
        return np.isfinite(self.gains)

    def as_dict(self) -> dict[str, Any]:
        """The gains as JSON can hold them."""
        rows = zip(self.gains.tolist(), self.intervals.tolist(), self.relative.tolist(), strict=True)
        return {
            "method": self.method,
            "gains_Nm_A": [None if math.isnan(gain) else gain for gain, _, _ in rows],
            "intervals_Nm_A": [i if ok else None for i, ok in zip(self.intervals.tolist(), self.found, strict=True)],
            "load_mass_kg": float(self.load[0]),
            "load": dict(zip(PARAMETER_NAMES, self.load.tolist(), strict=True)),
            "unexplained_percent": self.relative.tolist(),
            "blocks": self.blocks,
            "recordings": list(self.recordings),
        }

    def __repr__(self) -> str:
        rows = [f"drive gains by {self.method}, from a load of {self.load[0]:g} kg; intervals hold 95 %"]
        rows.append("joint  gain [N m/A]  interval          unexplained current %")
        for j, (gain, (low, high), left) in enumerate(zip(self.gains, self.intervals, self.relative, strict=True), 1):
            if math.isnan(gain):
                rows.append(f"{j:5d}  cannot be found: only its products with this joint's parameters show")
                continue
            word = "  vague" if (high - low) / (2 * gain) > VAGUE else ""
            rows.append(f"{j:5d}  {gain:12.4g}  [{low:.4g}, {high:.4g}]".ljust(40) + f"{left:8.2f}{word}")
        if self.method == "ls":
            rows.append(
                "least squares takes the noise of the currents for signal and finds gains that are too small; use tls"
            )
        if self.found.all():
            rows.append(f'for other commands: --drive-gains "{" ".join(f"{g:.4g}" for g in self.gains)}"')
        lost = np.flatnonzero(~self.found) + 1
        width = np.array(
            [(high - low) / (2 * abs(gain)) for gain, (low, high) in zip(self.gains, self.intervals, strict=True)]
        )
        sure = int(np.count_nonzero(width <= VAGUE))  # a gain that was not found has no width
        verdict = f"{sure} of {len(self.gains)} gains known within {100 * VAGUE:.0f} %, {self.found.sum() - sure} more only vaguely"
        return "\n".join(
            [*rows, f"verdict: {verdict}" + (f", not those of joints {', '.join(map(str, lost))}" if len(lost) else "")]
        )


def identify_drive_gains(
    robot: Robot,
    unloaded: Sequence[Recording],
    loaded: Sequence[Recording],
    load_mass: float,
    method: str = "tls",
    effects: Iterable[str | Effect] = DEFAULT_EFFECTS,
    filter: Filter | None = None,
) -> DriveGains:
    """Drive gains from currents recorded without and with a load of ``load_mass`` [kg] on the last link.

    Its centre of mass and inertia are found, not asked for. ``method`` "tls": total least squares, the errors belong to
    the currents, which multiply what is sought; "physical": the same with every link, the load, friction and rotors as
    real bodies have them; "ls": plain least squares, biased low by the currents' errors, for comparison. Gains the
    recordings hold are not used. Raises InputError without loaded recordings or a mass, for torques instead of currents, and
    where no gain can be told from the parameters it multiplies; NotSolvedError where the iteration does not settle.
    """
    _check(unloaded, loaded, load_mass, method)
    made = make_effects(effects)
    if bent := [effect.name for effect in made if effect.needs_model]:
        raise InputError(
            f"drive gains cannot be found beside {', '.join(bent)}, which depend on the torque itself; expected other effects"
        )
    if sought := [f"{e.name} ({s.field})" for e in made for s in e.shape_parameters if getattr(e, s.field) is None]:
        raise InputError(
            f"drive gains cannot be found beside {', '.join(sought)}, whose shape would have to be sought along; expected other effects"
        )
    _check_mass(robot, load_mass)
    filter = filter or Filter()
    recordings = [recording.with_drive_gains([1.0] * recording.n) for recording in (*unloaded, *loaded)]
    regressor = build_regressor(robot, made, prepare_moving(robot, recordings, filter), filter)
    base = find_base_parameters(robot, made)
    equations = GainEquations(regressor, base, regressor.recording >= len(unloaded), load_mass)
    if not equations.load_felt:
        raise InputError(
            "the load exerts no torque on any joint, so that gains show only in products with the arm's parameters; expected a motion in which joints carry or swing the load"
        )
    solution = equations.total_least_squares() if method != "ls" else equations.least_squares()
    if method == "physical":
        from physident.estimation.drive_gains.cones import solve_on_cones

        solution = solve_on_cones(equations, robot, made, solution)
    found = equations.decided(solution)
    if not found.any():
        raise InputError(
            "no gain can be told from the parameters it multiplies: only their products show; expected a load that gravity or acceleration puts on the joints"
        )
    covariance, blocks = equations.log_covariance(solution)
    gains = np.where(found, solution.gains, np.nan)
    spread = np.exp(t_quantile(blocks) * np.sqrt(np.diag(covariance)))
    return DriveGains(
        method, gains, np.column_stack([gains / spread, gains * spread]), covariance, blocks,
        solution.load, equations.unexplained(solution), tuple(recording.source for recording in (*unloaded, *loaded)),
    )  # fmt: skip


def _check_mass(robot: Robot, load_mass: float) -> None:
    """No arm carries ten times its own weight: such a mass is in grams."""
    own = float(robot.nominal[::10].sum())
    if 0 < HEAVIEST * own < load_mass:
        raise InputError(
            f"load mass is {load_mass:g} kg, but the links of {robot.name} weigh {own:.3g} kg together; expected kilograms"
        )


def _check(unloaded: Sequence[Recording], loaded: Sequence[Recording], load_mass: float, method: str) -> None:
    if method not in METHODS:
        raise InputError(f"method {method!r} is unknown, expected one of {', '.join(METHODS)}")
    if not (math.isfinite(load_mass) and load_mass > 0):
        raise InputError(f"load mass is {load_mass} kg, expected a positive number: weigh the load")
    if not unloaded or not loaded:
        which = "without load" if not unloaded else "with a known load"
        raise InputError(
            f"no recordings {which}; expected both: without them currents show only products of gains and parameters"
        )
    for recording in (*unloaded, *loaded):
        if recording.effort_kind != "current":
            raise InputError(
                f"{recording.source}: holds torques, expected motor currents [A]; drive gains turn one into the other"
            )
        refuse_constant(recording)
    refuse_twice(unloaded)
    refuse_twice(loaded)
    both = {r.sha256 for r in unloaded} & {r.sha256 for r in loaded}
    if both:
        name = next(r.source for r in loaded if r.sha256 in both)
        raise InputError(f"{name}: given both without and with load; expected each recording once")
