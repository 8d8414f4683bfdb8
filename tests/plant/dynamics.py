"""Forward dynamics of the controlled arm in time: steps of even length, cut short where friction turns.

Dry friction is followed from event to event: a sliding element whose speed changes sign is brought to rest at that very
instant, where it sticks or turns. Steps in which smooth friction or bristles turn are refined.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tests.plant.arm import Arm
from tests.plant.controller import Controller
from tests.plant.forces import Controlled, Forces, Instant, State
from tests.plant.laws import Dry
from tests.plant.motions import Motion
from tests.plant.stepping import Stepper
from tests.plant.sticking import Sticking
from tests.plant.turns import Turns

Array = NDArray[np.float64]
STEP = 1e-3  # s
TURN = 0.15  # share of its level by which friction may change in one step
SHORTEST = 1 / 64  # of a step
PARTS_AT_MOST = 2000  # of one step
AT_REST = 1e-7  # rad/s: an element this slow where it turns is brought to rest


@dataclass(frozen=True, eq=False)
class Run:
    """A simulated motion at steps (N,) [s]: ``q`` [rad], ``v`` [rad/s], ``a`` [rad/s^2] (N, n) of the rotors at the joints
    (those of the links where the gear is stiff), ``link_q``, ``link_v``, ``link_a`` of the links, the ``torque`` (N, n)
    [N m] of the motors, and which joints are stuck (N, n), where friction is dry."""

    time: Array
    q: Array
    v: Array
    a: Array
    link_q: Array
    link_v: Array
    link_a: Array
    torque: Array
    stuck: NDArray[np.bool_]


def simulate(arm: Arm, motion: Motion, controller: Controller | None = None, step: float = STEP) -> Run:
    """The arm following a motion under control, from rest, in steps of ``step`` [s]."""
    controller = controller or Controller()
    time: Array = np.arange(round(motion.duration / step) + 1, dtype=float) * np.float64(step)
    command = controller.ahead(*motion.states(time))
    # the controller sees the encoders: true position less the zero offset
    command = command + np.array(controller.proportional) * arm.zero_offset
    plant = Controlled(arm, controller, time)
    y, w, a, torque, stuck = _Course(plant, command).follow()
    n, rotor = plant.n, plant.rotor
    return Run(time, y[:, rotor], w[:, rotor], a[:, rotor], y[:, :n], w[:, :n], a[:, :n], torque, stuck)


class _Course:
    """The way of an arm through time under commands (N, n) [N m]."""

    def __init__(self, arm: Controlled, command: Array) -> None:
        self.arm, self.command = arm, command
        self.dry = isinstance(arm.friction.law, Dry)
        self.stepper, self.sticking, self.turns = Stepper(arm), Sticking(arm), Turns(arm)
        self.step = float(arm.time[1] - arm.time[0])
        self.since = np.array([start for start, _ in arm.carried])
        self.warming = bool(np.ptp(arm.warm, axis=0).any())

    def instant(self, row: int, share: float = 0.0) -> Instant:
        """A share of a step after a row; a contact and a carried load change at rows only."""
        arm = self.arm
        bodies = arm.carried[0 if len(self.since) == 1 else int(np.sum(self.since <= arm.time[row] + 1e-9)) - 1][1]
        command, warm = self.command[row], arm.warm[row]
        if share:
            command = command + share * (self.command[row + 1] - command)
            if self.warming:
                warm = warm + share * (arm.warm[row + 1] - warm)
        return Instant(arm.time[row] + share * self.step, command, warm, row, bodies)

    def follow(self) -> tuple[Array, Array, Array, Array, NDArray[np.bool_]]:
        """Positions, speeds, accelerations (N, size), torques asked for (N, n), and what is stuck (N, n)."""
        arm, count = self.arm, len(self.command)
        m = len(arm.elements)
        state = State(arm.rest(self.command[0]), np.zeros(arm.size), np.zeros(m), np.zeros(arm.n), np.zeros(m))
        Y, W, A = np.empty((3, count, arm.size))
        T, stuck = np.empty((count, arm.n)), np.zeros((count, arm.n), dtype=bool)
        for k in range(count):
            state, forces, A[k] = self._held(self.instant(k), state)
            Y[k], W[k], T[k] = state.y, state.w, forces.asked
            if self.dry:
                stuck[k] = state.modes[: arm.n] == 0
            if k + 1 < count:
                state = self.turns.remembered(k, self.step, state, self._advance(k, state, forces))
        return Y, W, A, T, stuck

    def _held(self, now: Instant, state: State) -> tuple[State, Forces, Array]:
        """The state with its resting elements decided, its forces and accelerations (size,)."""
        forces = self.arm.at(now, state)
        if not self.dry:
            return state, forces, self.sticking.accelerations(forces, None)
        held = self.sticking.settle(now, state, forces)
        state = state if held.modes is state.modes else replace(state, modes=held.modes)
        return state, held.forces, held.a

    def _advance(self, row: int, state: State, forces: Forces) -> State:
        """The state one step after a row."""
        done, part = 0.0, 1.0
        for _ in range(PARTS_AT_MOST):
            part = min(part, 1.0 - done)
            new, guess, reached = self._to_first_rest(row, done, part, state, forces)
            # the guess too: a friction that turned and turned back within the step was not followed
            if reached > SHORTEST and self.turns.turned(row, forces, state, new, guess) > TURN:
                part = reached / 2
                continue
            done += reached
            if done > 1.0 - 1e-9:
                return new
            part = 2 * part
            state, forces, _ = self._held(self.instant(row, done), new)
        raise RuntimeError(f"friction turns too often near {self.arm.time[row]:.4f} s")

    def _to_first_rest(
        self, row: int, done: float, part: float, state: State, forces: Forces
    ) -> tuple[State, State, float]:
        """The state a part of a step further, or where the first sliding element comes to rest before, the step's guess of
        it, and that part."""
        basis = self.sticking.basis(state.modes) if self.dry else None
        start, late = self.instant(row, done), np.zeros(len(state.modes), dtype=bool)
        while True:
            new, guess = self.stepper.step(start, self.instant(row, done + part), state, forces, basis)
            if not self.dry:
                return new, guess, part
            before, after = state.modes * (self.arm.elements @ np.array([state.w, new.w]).T).T
            over = after < -AT_REST
            late |= over
            if not over.any() or part <= SHORTEST**2:
                break
            # the first to come to rest decides; one that only just began to slide is looked at more closely
            shares = np.where(before > AT_REST, before / np.maximum(before - after, AT_REST), 0.5)
            part *= float(np.min(shares[over]))
        rests = (after < 0) | (late & (after <= AT_REST))
        if rests.any():
            modes = np.where(rests, 0.0, state.modes)
            still = self.sticking.basis(modes)
            assert still is not None
            new = replace(new, modes=modes, w=still @ (still.T @ new.w))
        return new, guess, part
