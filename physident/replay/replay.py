"""Replays recordings in a simulator, from every measured state under the measured torque and along the motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.effects.classification import Detection
from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.export.held import described
from physident.graphics.scene import link_poses, tool_path
from physident.recordings.recording import Recording
from physident.recordings.signals import Signals
from physident.replay.arm import Arm
from physident.replay.mujoco_simulator import MujocoArm
from physident.replay.own_simulator import STEP, Drive, Trace, simulate_batch
from physident.replay.score import Replay, ReplayScore
from physident.replay.windows import Windows, cut_windows, drive_torque, signals_of
from physident.robots.robot import Robot
from physident.simulation.controllers import BANDWIDTH, PD
from physident.simulation.plant import Instants

Array = NDArray[np.float64]
Simulator = Literal["mujoco", "physident"]
SHORTEST, LONGEST = 0.02, 10.0  # s: of a horizon
SETTLING = 4.0 / BANDWIDTH  # s: the arm starts on the motion, where the controller adds nothing yet
HELD_PERIODS = 10.0  # of the cutoff: how long an arm is then held along the motion, twice as long as the filter
MOST_STARTS = 2000  # of a replay: a start more often than this tells nothing new
AWAY = np.pi  # rad or m: an arm this far away is lost


@dataclass(frozen=True, eq=False)
class Replayed:
    """The errors of a replay, and the traces that they are of, for figures and sessions."""

    replay: Replay
    signals: list[Signals]
    windows: Windows
    traces: tuple[Trace, ...]


def replay(
    before: Estimate,
    after: Estimate | None,
    recordings: Sequence[Recording],
    simulator: Simulator = "mujoco",
    horizon: float = 0.5,
) -> Replayed:
    """How far the simulated arms of one model or two are from the recorded one.

    From every measured state (each row that the filter keeps) the arm is simulated for ``horizon`` [s] under the measured
    torque, less what the model says of the torque measurement; and for a few seconds at a time along the recorded motion,
    where a PD controller, whose gains are those of the first model, adds the torque that the simulated arm lacks. Raises InputError for a simulator that does not exist,
    a horizon out of range, models of different joints, and recordings that do not fit.
    """
    if simulator not in ("mujoco", "physident"):
        raise InputError(f"simulator is {simulator!r}, expected mujoco or physident")
    if not SHORTEST <= horizon <= LONGEST:
        raise InputError(f"horizon is {horizon:g} s, expected {SHORTEST:g} to {LONGEST:g} s")
    if after is not None and after.model.robot.joint_names != before.model.robot.joint_names:
        raise InputError("the two models have different joints; expected models of one arm")
    if not recordings:
        raise InputError("no recordings given, expected at least one to replay")
    signals = signals_of(before, recordings)
    rate = min(one.rate for one in signals)
    moving = sum(np.ptp(one.moving) for one in signals if one.moving is not None)
    every = max(before.filter.decimation(rate) / rate, moving / MOST_STARTS)
    windows = cut_windows(signals, horizon, every)
    length = SETTLING + HELD_PERIODS / before.filter.cutoff
    held = cut_windows(signals, length, length / 2)
    gains = PD.of_bandwidth(before.model, windows.q[:, 0].mean(axis=0), step=STEP)
    scores, traces = [], []
    for estimate in [before] if after is None else [before, after]:
        score, trace = _scored(estimate, signals, windows, held, gains, simulator)
        scores.append(score)
        traces.append(trace)
    result = Replay(
        joints=before.model.robot.joint_names,
        units=before.model.robot.units_where_it_slides("mrad", "mrad/s", "N m"),
        simulator=simulator,
        horizon=horizon,
        controller=f"a PD controller of {BANDWIDTH:g} Hz beside the measured torque",
        starts=len(windows),
        recordings=tuple(recording.source for recording in recordings),
        before=scores[0],
        after=scores[1] if after is not None else None,
    )
    return Replayed(result, signals, windows, tuple(traces))


def _scored(
    estimate: Estimate, signals: list[Signals], windows: Windows, held: Windows, gains: PD, simulator: Simulator
) -> tuple[ReplayScore, Trace]:
    model, robot = estimate.model, estimate.model.robot
    torque = drive_torque(model, windows)
    free = _simulated(estimate, signals, windows, _interpolated(windows, torque, STEP / 2), False, simulator)
    error = free.q - windows.q
    ahead = np.where(np.isfinite(error[:, -1]), error[:, -1], AWAY)
    lost = float((np.abs(ahead) >= AWAY).any(axis=1).mean())
    ahead = np.clip(ahead, -AWAY, AWAY)
    reached = windows.q[:, -1] + ahead
    speed = np.nan_to_num(free.v[:, -1] - windows.v[:, -1], nan=AWAY / windows.clock[-1])
    measured = drive_torque(model, held)
    kept = _simulated(estimate, signals, held, _controller(measured, held, gains), True, simulator)
    settled = round(SETTLING / held.step)
    off = np.nan_to_num(np.abs(kept.q - held.q), nan=AWAY).max(axis=(1, 2))
    difference = kept.torque - measured
    difference = np.where(np.isfinite(difference), difference, measured)  # of a lost arm, all torque is an error
    difference = difference[:, settled:].transpose(0, 2, 1)
    filtered = estimate.filter.apply(difference.reshape(len(held) * robot.n, -1), 1 / held.step)
    filtered = filtered.reshape(len(held), robot.n, -1)
    following = np.nan_to_num(kept.q - held.q, nan=AWAY)[:, settled:]
    score = ReplayScore(
        position=_rms(ahead, (0,)),
        velocity=_rms(speed, (0,)),
        tool=_tool_distance(robot, reached, windows.q[:, -1]),
        torque=_rms(filtered, (0, 2)),
        following=_rms(following, (0, 1)),
        tool_following=_tool_distance(
            robot, (held.q[:, settled:] + following).reshape(-1, robot.n), held.q[:, settled:].reshape(-1, robot.n)
        ),
        lost=lost,
        lost_following=float((off >= AWAY).mean()),
        stated=(*(MujocoArm(model).exported.stated if simulator == "mujoco" else ()), *_not_simulated(model)),
    )
    return score, free


def _not_simulated(model: Model) -> tuple[str, ...]:
    """One line for each effect that neither simulator has: one of an event, or one that needs other instants."""
    parts = [(e, theta) for e, theta in model.effect_parameters() if e.acts_on == "plant"]
    return tuple(
        f"not simulated: {described(model.robot, effect, theta)}"
        for effect, theta in parts
        if effect.detection is Detection.BY_TIME or not (effect.pointwise or effect.state_size(model.robot))
    )


def _simulated(
    estimate: Estimate, signals: list[Signals], windows: Windows, command: Drive, closed: bool, simulator: Simulator
) -> Trace:
    """The simulated arms as the encoders show them."""
    arm = Arm(estimate.model)
    q, v = arm.true(windows.q[:, 0], windows.v[:, 0])

    def drive(time: float, q: Array, v: Array) -> Array:
        return command(time, *arm.measured(q, v))

    if simulator == "mujoco":
        machine = MujocoArm(estimate.model)
        state = np.zeros((0, len(q))) if machine.left_out is None else _states(machine.left_out, signals, windows)
        trace = machine.simulate(windows.clock, windows.start, state, q, v, drive, closed)
    else:
        trace = simulate_batch(arm, windows.clock, windows.start, _states(arm, signals, windows), q, v, drive)
    shown_q, shown_v = arm.measured(trace.q.reshape(-1, q.shape[1]), trace.v.reshape(-1, q.shape[1]))
    return Trace(shown_q.reshape(trace.q.shape), shown_v.reshape(trace.v.shape), trace.torque)


def _states(arm: Arm, signals: list[Signals], windows: Windows) -> Array:
    """Internal states (S, W) of the effects at each start: those after the measured motion since the recording's beginning."""
    result = np.zeros((arm.plant.states, len(windows)))
    for index, one in enumerate(signals if arm.plant.states else []):
        state = np.zeros((arm.plant.states, 1))
        wanted = {round(s * one.rate): w for w, s in enumerate(windows.start) if windows.recording[w] == index}
        known = {round((t - one.origin) * one.rate): k for k, t in enumerate(one.time)}
        for sample in range(max(wanted) + 1 if wanted else 0):
            k = known.get(sample)
            if sample in wanted:
                result[:, wanted[sample]] = state[:, 0]
            if k is not None:
                rows = slice(k, k + 1)
                still = np.zeros_like(one.q[rows])
                at = Instants(one.time[rows] - one.origin, one.q[rows], one.v[rows], still, still, state)
                state = arm.advanced(at, 1 / one.rate)
    return result


def _interpolated(windows: Windows, values: Array, ahead: float = 0.0) -> Drive:
    """Values (W, T, n) at a time ``ahead`` [s] of any time of their clock, linear between samples, whatever the state."""

    def at(time: float, q: Array, v: Array) -> Array:
        place = min((time + ahead) / windows.step, len(windows.clock) - 1.0)
        k = min(int(place), len(windows.clock) - 2)
        share = place - k
        return (1 - share) * values[:, k] + share * values[:, k + 1]

    return at


def _controller(measured: Array, windows: Windows, gains: PD) -> Drive:
    """The measured torque, and that of a PD controller along the measured motion."""
    stiffness, damping = np.array(gains.stiffness), np.array(gains.damping)
    wanted = _interpolated(windows, measured + stiffness * windows.q + damping * windows.v)

    def at(time: float, q: Array, v: Array) -> Array:
        return wanted(time, q, v) - stiffness * q - damping * v

    return at


def _rms(values: Array, axes: tuple[int, ...]) -> Array:
    return np.sqrt((values**2).mean(axis=axes))


def _tool_distance(robot: Robot, q: Array, other: Array) -> float:
    """Distance [m] between the tools at positions q and other (N, n), RMS."""
    ends = [tool_path(robot, *link_poses(robot, positions)) for positions in (q, other)]
    return float(np.sqrt(((ends[0] - ends[1]) ** 2).sum(axis=1).mean()))
