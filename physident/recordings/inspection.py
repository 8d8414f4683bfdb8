"""Facts about a recording before anything is fitted to it: clock, ranges, standstill, velocity check, frequency bands."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.large_arrays import blocks, limits, magnitude
from physident.recordings.channels import BadRow
from physident.recordings.motion_smoothing import velocity_std
from physident.recordings.preparation import differentiate, motion_noise, prepare
from physident.recordings.recording import Recording
from physident.recordings.rows import typical_step
from physident.recordings.signals import MOVING_SPEED, Filter, Signals
from physident.recordings.white_noise import spectrum_of
from physident.robots.robot import Robot

Array = NDArray[np.float64]
MAX_BAD_ROWS = 20  # bad rows that are listed
CONTRARY = 50.0  # %: no filter or delay of a few samples makes a measured velocity differ as much from the derivative of position
MIN_REST = 0.3  # s: a shorter standstill is a reversal


@dataclass(frozen=True, eq=False, kw_only=True)
class Inspection:
    """Facts about one recording of n joints.

    ``rate`` [Hz] from the typical step of the clock; ``jitter`` [s] standard deviation and ``longest`` [s] maximum of the
    steps; ``position`` (n, 2) [rad|m] and ``effort`` (n, 2) [N m|A] ranges, ``speed`` (n,) [rad/s|m/s] maximum;
    ``velocity_error`` (n,) [%] and ``velocity_delay`` (n,) [s] of the measured velocity relative to the derivative of
    position, NaN where velocity is not measured or the joint stands still; ``noise`` (n, 3) the standard deviations of measured
    positions [rad|m] and velocities [rad/s|m/s], infinite where velocity is not measured, and of the velocity that is found
    from both; ``rest`` the intervals [s] of standstill;
    ``motion_band``, ``effort_band`` (n,) [Hz] below which 99 % of the power above the noise lies; ``cutoff`` [Hz] suggested
    for the filter; ``units`` says of a known arm in which units the joints that slide are shown.
    """

    recording: Recording
    rate: float
    jitter: float
    longest: float
    position: Array
    speed: Array
    effort: Array
    velocity_error: Array
    velocity_delay: Array
    noise: Array
    rest: tuple[tuple[float, float], ...]
    motion_band: Array
    effort_band: Array
    cutoff: float
    units: str = ""

    @property
    def bad_rows(self) -> tuple[BadRow, ...]:
        """The rows that were left out, with the reason."""
        return self.recording.rejected

    def as_dict(self) -> dict[str, Any]:
        """The facts as plain numbers and texts for JSON; None where a number is not known."""
        r = self.recording
        arrays = {
            "position": self.position,
            "speed": self.speed,
            "effort": self.effort,
            "velocity_error_percent": self.velocity_error,
            "velocity_delay_s": self.velocity_delay,
            "noise": self.noise,
            "motion_band_Hz": self.motion_band,
            "effort_band_Hz": self.effort_band,
        }
        return {
            "path": r.source,
            "sha256": r.sha256,
            "joints": r.n,
            "rows": len(r.time),
            "duration_s": float(r.duration),
            "rate_Hz": float(self.rate),
            "jitter_s": float(self.jitter),
            "longest_step_s": float(self.longest),
            "effort_kind": r.effort_kind,
            "bad_rows": [asdict(bad) for bad in self.bad_rows],
            "columns_ignored": list(r.ignored),
            "rest_s": [list(span) for span in self.rest],
            **{name: _known(array) for name, array in arrays.items()},
            "suggested_cutoff_Hz": float(self.cutoff),
            "verdict": _verdict(self).removeprefix("verdict: "),
        }

    def __repr__(self) -> str:
        return "\n".join([*_facts(self), *_table(self), _verdict(self)])


def inspect_recording(recording: Recording, robot: Robot | None = None) -> Inspection:
    """Facts about a recording; works for currents without drive gains. The ``robot`` says which joints slide.

    Raises InputError for a recording without a contiguous part, or with other joints than the robot."""
    if robot is not None and robot.n != recording.n:
        raise InputError(
            f"{recording.source}: {recording.n} joints, but robot {robot.name} has {robot.n}; check --robot, --joints and --columns"
        )
    rate = 1 / typical_step(recording.time)
    wide = Filter(cutoff=min(10.0, 0.3 * rate))
    unit = recording.with_drive_gains([1.0] * recording.n) if recording.effort_kind == "current" else recording
    signals = prepare(unit, wide)
    assert signals.torque is not None
    errors = _velocity_agreement(recording, wide)
    longest = max(signals.segments, key=lambda s: s.stop - s.start)
    motion = np.array([spectrum_of(v, signals.rate).band for v in signals.v[longest].T])
    efforts = [spectrum_of(torque, signals.rate) for torque in signals.torque[longest].T]
    noise_from = np.array([one.noise_from for one in efforts])
    jitter, gap = _clock(recording.time)
    return Inspection(
        recording=recording,
        rate=rate,
        jitter=jitter,
        longest=gap,
        position=limits(recording.q),
        speed=magnitude(signals.v),
        effort=limits(recording.effort),
        velocity_error=np.array([e[0] for e in errors]),
        velocity_delay=np.array([e[1] for e in errors]),
        noise=np.array([(one.position, one.velocity, velocity_std(rate, one)) for one in motion_noise(unit, wide)]),
        rest=_rest(signals.time, signals.v),
        motion_band=motion,
        effort_band=np.array([one.band for one in efforts]),
        cutoff=_suggest(motion, noise_from, rate),
        units="" if robot is None else robot.units_where_it_slides("rad", "rad/s", _unit(recording)),
    )


def _known(values: Array) -> Any:
    """An array as nested lists, None for what is not finite."""
    if values.ndim:
        return [_known(part) for part in values]
    return float(values) if np.isfinite(values) else None


def _velocity_agreement(recording: Recording, filter: Filter) -> list[tuple[float, float]]:
    """Of each joint the difference [%] after the best shift, and that shift [s], of measured velocity against the derivative of
    position; NaN where they cannot be compared."""
    if recording.dq is None:
        return [(np.nan, np.nan)] * recording.n
    signals = differentiate(replace(recording, dq=None, effort=recording.dq, effort_kind="torque"), filter)
    part = max(signals.segments, key=lambda s: s.stop - s.start)
    return [_agreement(signals, part, j) for j in range(recording.n)]


def _agreement(signals: Signals, part: slice, joint: int) -> tuple[float, float]:
    assert signals.torque is not None
    measured, derived = signals.torque[part, joint], signals.v[part, joint]
    if magnitude(derived) < MOVING_SPEED:
        return np.nan, np.nan
    # least squares for a small shift: measured(t) = derived(t - d) is derived - d * its derivative to first order
    products = np.zeros((3, 3))  # of the difference without a shift, the slope, and the derivative of position
    for rows in blocks(len(derived)):
        around = slice(max(0, rows.start - 1), min(len(derived), rows.stop + 1))
        inside = slice(rows.start - around.start, rows.stop - around.start)
        slope = np.gradient(derived[around], 1 / signals.rate)[inside]
        columns = np.array([measured[rows] - derived[rows], slope, derived[rows]])
        products += columns @ columns.T
    delay = -float(products[0, 1] / products[1, 1])
    left = products[0, 0] + 2 * delay * products[0, 1] + delay**2 * products[1, 1]
    return 100 * float(np.sqrt(max(left, 0.0) / products[2, 2])), delay


def _suggest(motion: Array, noise_from: Array, rate: float) -> float:
    """Ten times the band of motion, which keeps the steps of friction at reversals, up to where torque is only noise.

    The factor is the usual one between a robot's motion and the filter: Gautier, "Dynamic identification of robots with
    power model" (1997), sec. 4. The joint with the widest band decides, within what the clock allows.
    """
    widest = float(np.max(np.minimum(10 * motion, noise_from), initial=0.0))
    return float(np.clip(round(widest, 1), 2.0, 0.2 * rate)) if widest > 0 else min(5.0, 0.2 * rate)


def _rest(time: Array, v: Array) -> tuple[tuple[float, float], ...]:
    still = np.zeros(len(v) + 2, dtype=np.int8)
    for rows in blocks(len(v)):
        still[rows.start + 1 : rows.stop + 1] = (np.abs(v[rows]) <= MOVING_SPEED).all(axis=1)
    edges = np.flatnonzero(np.diff(still))
    spans = [(float(time[a]), float(time[b - 1])) for a, b in edges.reshape(-1, 2)]
    return tuple(span for span in spans if span[1] - span[0] >= MIN_REST)


def _clock(time: Array) -> tuple[float, float]:
    """Standard deviation and maximum [s] of the steps of a clock."""
    mean, squares, longest = (time[-1] - time[0]) / (len(time) - 1), 0.0, 0.0
    for rows in blocks(len(time) - 1):
        step = np.diff(time[rows.start : rows.stop + 1])
        squares, longest = squares + float(((step - mean) ** 2).sum()), max(longest, float(step.max()))
    return float(np.sqrt(squares / (len(time) - 1))), longest


def _facts(i: Inspection) -> list[str]:
    r = i.recording
    resting = sum(stop - start for start, stop in i.rest)
    unit = "N m"
    if r.effort_kind == "current":
        unit = "A, with drive gains" if r.drive_gains is not None else "A, without drive gains"
    rows = [
        r.source,
        f"{r.n} joints, {r.duration:.2f} s, {len(r.time)} rows at {i.rate:.4g} Hz"
        f" (jitter {1e3 * i.jitter:.2g} ms, longest step {1e3 * i.longest:.3g} ms)",
        f"effort: {r.effort_kind} [{unit}]; rest: {resting:.1f} s in {len(i.rest)} phase{'' if len(i.rest) == 1 else 's'}"
        + (f"; columns ignored: {len(r.ignored)}" if r.ignored else ""),
    ]
    rows += [f"  bad row {bad.row}: {bad.reason}" for bad in i.bad_rows[:MAX_BAD_ROWS]]
    if len(i.bad_rows) > MAX_BAD_ROWS:
        rows.append(f"  and {len(i.bad_rows) - MAX_BAD_ROWS} more bad rows")
    return rows


def _table(i: Inspection) -> list[str]:
    unit = _unit(i.recording)
    rows = [
        f"       position [rad]    max speed  {f'effort [{unit}]':<17}  dq against motion  99 % of power below [Hz]  noise of q, dq, and dq when smoothed",
        "joint     min     max      [rad/s]       min      max  error %  delay ms  motion  effort       [rad]   [rad/s]   [rad/s]",
    ]
    for j in range(i.recording.n):
        known = bool(np.isfinite(i.velocity_error[j]))
        delay = round(1e3 * i.velocity_delay[j], 1) + 0.0 if known else np.nan  # never -0.0
        agree = f"{i.velocity_error[j]:7.1f}  {delay:8.1f}" if known else f"{'-':>7}  {'-':>8}"
        rows.append(
            f"{j + 1:5d}  {i.position[j, 0]:6.3f}  {i.position[j, 1]:6.3f}  {i.speed[j]:11.3f}"
            f"  {i.effort[j, 0]:8.3f} {i.effort[j, 1]:8.3f}  {agree}  {i.motion_band[j]:6.2f}  {i.effort_band[j]:6.2f}"
            f"     {i.noise[j, 0]:.1e}  {'        -' if np.isinf(i.noise[j, 1]) else f'{i.noise[j, 1]:9.1e}'}  {i.noise[j, 2]:8.1e}"
        )
    return [*rows, i.units] if i.units else rows


def _unit(recording: Recording) -> str:
    return "N m" if recording.effort_kind == "torque" else "A"


def _verdict(i: Inspection) -> str:
    if len(i.rest) == 1 and i.rest[0][1] - i.rest[0][0] > 0.95 * i.recording.duration:
        return "verdict: no joint moves; a static pose shows only gravity and stiction, which is not enough to identify a model"
    still = [str(j + 1) for j in range(i.recording.n) if i.speed[j] < MOVING_SPEED]
    parts = []
    contrary = [str(j + 1) for j in np.flatnonzero(i.velocity_error > CONTRARY)]
    if contrary:
        parts.append(f"dq contradicts q on joint{'s' if len(contrary) > 1 else ''} {', '.join(contrary)}")
    parts.append(f"suggested --cutoff {i.cutoff:g}")
    if still:
        parts.append(
            f"joint{'s' if len(still) > 1 else ''} {', '.join(still)} never move{'' if len(still) > 1 else 's'}"
        )
    if i.bad_rows:
        parts.append(f"{len(i.bad_rows)} bad row{' is' if len(i.bad_rows) == 1 else 's are'} left out")
    return "verdict: " + "; ".join(parts)
