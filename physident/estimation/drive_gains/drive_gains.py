"""Drive gains: joint torque for each ampere of motor current, from recordings with and without a known load.

K_j i_j = Y_j theta holds for any common multiple of all gains and parameters: recordings without a known load give
only products. A load of known mass is a torque that is not multiplied by anything unknown, and fixes the scale.
Source: Gautier, Briot, "Global identification of joint drive gains and dynamic parameters of robots" (2014), sec. 3.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.regressor import build_regressor
from physident.effects.catalogue import DEFAULT_EFFECTS, make_effects
from physident.effects.effect import Effect
from physident.errors import InputError, did_you_mean
from physident.estimation.drive_gains.contradictions import contradictions
from physident.estimation.drive_gains.equations import GainEquations
from physident.estimation.identify import prepare_moving
from physident.estimation.uncertainty import t_quantile
from physident.identifiability.base_parameters import find_base_parameters
from physident.recordings.checks import refuse_constant, refuse_duplicates
from physident.recordings.load import Recordings, as_recordings
from physident.recordings.recording import Recording
from physident.recordings.signals import Filter, as_filter
from physident.robots.inertia import PARAMETER_NAMES
from physident.robots.load import as_robot
from physident.robots.robot import Robot
from physident.setup_checks.check_setup import warn_of_setup
from physident.threads import one_thread

Array = NDArray[np.float64]
METHODS = ("tls", "ls", "physical")
HEAVIEST = 10.0  # of the arm's own mass
VAGUE = 0.15  # half-width of a relative interval above which a gain is called vague
LARGEST_EXPONENT = 700.0  # of an interval that says nothing; numbers beyond overflow


@dataclass(frozen=True, eq=False, kw_only=True)
class DriveGains:
    """Joint torque for each ampere of motor current.

    ``gains`` (n,) [N m/A], NaN where they cannot be identified; ``intervals`` (n, 2) cover 95 %; ``covariance`` (n, n) of
    the gains' logarithms, from ``blocks`` blocks. ``load`` (10,) [kg, kg m, kg m^2]: the load in the last link's frame,
    with the given mass. ``relative`` (n,) [%] of the current that is not explained. ``warnings`` say why gains and intervals
    cannot be believed.
    """

    method: str
    gains: Array
    intervals: Array
    covariance: Array
    blocks: int
    load: Array
    relative: Array
    recordings: tuple[str, ...]
    warnings: tuple[str, ...] = ()

    @property
    def found(self) -> NDArray[np.bool_]:
        """Which gains (n,) the recordings determine."""
        return np.isfinite(self.gains)

    def as_dict(self) -> dict[str, Any]:
        """The gains as plain numbers and texts for JSON."""
        rows = zip(self.gains.tolist(), self.intervals.tolist(), self.relative.tolist(), strict=True)
        return {
            "method": self.method,
            "gains_Nm_A": [None if math.isnan(gain) else gain for gain, _, _ in rows],
            "intervals_Nm_A": [
                i if ok and not self.warnings else None
                for i, ok in zip(self.intervals.tolist(), self.found, strict=True)
            ],
            "load_mass_kg": float(self.load[0]),
            "load": dict(zip(PARAMETER_NAMES, self.load.tolist(), strict=True)),
            "unexplained_percent": self.relative.tolist(),
            "blocks": self.blocks,
            "warnings": list(self.warnings),
            "recordings": list(self.recordings),
        }

    def __repr__(self) -> str:
        title = "intervals withheld" if self.warnings else "intervals cover 95 %"
        rows = [f"drive gains by {self.method}, from a load of {self.load[0]:g} kg; {title}"]
        rows.append("joint  gain [N m/A]  interval          unexplained current %")
        for j, (gain, (low, high), unexplained) in enumerate(
            zip(self.gains, self.intervals, self.relative, strict=True), 1
        ):
            if math.isnan(gain):
                rows.append(f"{j:5d}  cannot be separated from this joint's parameters")
                continue
            word = "  vague" if (high - low) / (2 * gain) > VAGUE else ""
            interval = "" if self.warnings else f"[{low:.4g}, {high:.4g}]"
            rows.append(
                f"{j:5d}  {gain:12.4g}  {interval}".ljust(40) + f"{unexplained:8.2f}{'' if self.warnings else word}"
            )
        if self.method == "ls":
            rows.append("least squares is biased by the noise of the currents: its gains are too small; use tls")
        if self.warnings:
            return "\n".join([*rows, f"verdict: doubtful: {'; '.join(self.warnings)}"])
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


@one_thread
def identify_drive_gains(
    robot: Robot | str | Path,
    unloaded: Recordings,
    loaded: Recordings,
    load_mass: float,
    method: str = "tls",
    effects: str | Iterable[str | Effect] = DEFAULT_EFFECTS,
    filter: Filter | float | None = None,
) -> DriveGains:
    """Drive gains from currents recorded without and with a load of ``load_mass`` [kg] on the last link.

    ``robot`` may be a name or a path, recordings one or several recordings, paths or patterns.
    The load's centre of mass and inertia are identified as well. ``method`` "tls": total least squares, whose errors are
    those of the currents; "physical": the same with physically consistent links, load, friction and rotor inertias; "ls":
    ordinary least squares, biased low by the currents' errors, for comparison. Gains stored in the recordings are not
    used. Raises InputError without loaded recordings or a mass, for torques instead of currents, and where no gain can be
    separated from the parameters it multiplies; NotSolvedError where the iteration does not settle.
    """
    robot = as_robot(robot)
    unloaded, loaded = (as_recordings(given, robot) for given in (unloaded, loaded))
    _check(unloaded, loaded, load_mass, method)
    warn_of_setup(None, [*unloaded, *loaded])
    effects = make_effects(effects)
    if dependent := [effect.name for effect in effects if effect.needs_model]:
        raise InputError(
            f"drive gains cannot be identified together with {', '.join(dependent)}, which depend on the torque itself; expected other effects"
        )
    if open_shapes := [
        f"{e.name} ({s.field})" for e in effects for s in e.shape_parameters if getattr(e, s.field) is None
    ]:
        raise InputError(
            f"drive gains cannot be identified together with {', '.join(open_shapes)}, whose shape parameters are not set; expected other effects, or set them"
        )
    _check_mass(robot, load_mass)
    filter = as_filter(filter)
    recordings = [recording.with_drive_gains([1.0] * recording.n) for recording in (*unloaded, *loaded)]
    regressor = build_regressor(robot, effects, prepare_moving(robot, recordings, filter), filter)
    base = find_base_parameters(robot, effects)
    equations = GainEquations(regressor, base, regressor.recording >= len(unloaded), load_mass)
    if not equations.load_felt:
        raise InputError(
            "the load exerts no torque on any joint, so gains cannot be separated from the arm's parameters; expected a motion in which joints carry or swing the load"
        )
    solution = equations.total_least_squares() if method != "ls" else equations.least_squares()
    if method == "physical":
        from physident.estimation.drive_gains.physical_gains import solve_on_cones

        solution = solve_on_cones(equations, robot, effects, solution)
    found = equations.decided(solution)
    if not found.any():
        raise InputError(
            "no gain can be separated from the parameters it multiplies; expected a load whose weight or inertia acts on the joints"
        )
    covariance, blocks = equations.log_covariance(solution)
    gains = np.where(found, solution.gains, np.nan)
    spread = np.exp(np.minimum(t_quantile(blocks) * np.sqrt(np.diag(covariance)), LARGEST_EXPONENT))
    return DriveGains(
        method=method,
        gains=gains,
        intervals=np.column_stack([gains / spread, gains * spread]),
        covariance=covariance,
        blocks=blocks,
        load=solution.load,
        relative=equations.unexplained(solution),
        recordings=tuple(recording.source for recording in (*unloaded, *loaded)),
        warnings=contradictions(equations, solution, [recording.source for recording in recordings]),
    )


def _check_mass(robot: Robot, load_mass: float) -> None:
    """An arm cannot carry ten times its weight: such a mass is probably in grams."""
    arm_mass = float(robot.nominal[::10].sum())
    if 0 < HEAVIEST * arm_mass < load_mass:
        raise InputError(
            f"load mass is {load_mass:g} kg, but the links of {robot.name} weigh {arm_mass:.3g} kg together; expected kilograms"
        )


def _check(unloaded: Sequence[Recording], loaded: Sequence[Recording], load_mass: float, method: str) -> None:
    if method not in METHODS:
        raise InputError(
            f"method {method!r} is unknown, expected one of {', '.join(METHODS)}{did_you_mean(method, METHODS)}"
        )
    if not (math.isfinite(load_mass) and load_mass > 0):
        raise InputError(f"load mass is {load_mass} kg, expected a positive number: weigh the load")
    if not unloaded or not loaded:
        which = "without load" if not unloaded else "with a known load"
        raise InputError(
            f"no recordings {which}; expected both: otherwise gains cannot be separated from the arm's parameters"
        )
    for recording in (*unloaded, *loaded):
        if recording.effort_kind != "current" and recording.effort_stated:
            raise InputError(f"{recording.source}: contains torques, expected motor currents [A]")
        refuse_constant(recording)
    refuse_duplicates(unloaded)
    refuse_duplicates(loaded)
    both = {r.sha256 for r in unloaded} & {r.sha256 for r in loaded}
    if both:
        name = next(r.source for r in loaded if r.sha256 in both)
        raise InputError(f"{name}: given both without and with load; expected each recording once")
