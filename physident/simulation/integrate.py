"""Forward dynamics: the true motion of a simulated arm over time."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.errors import InputError, NotSolvedError
from physident.excitation.motion.motion import Motion
from physident.recordings.signals import Signals
from physident.simulation.controllers import PD, Controller
from physident.simulation.plant import Plant
from physident.simulation.radau import NODES, ExtraTorque, State, Stepper

Array = NDArray[np.float64]
STEP = 0.004  # s
LONGEST_STEP = 0.02  # s: five steps in a period of 10 Hz, as fast as an arm's motion gets
HALVINGS = 8
SMOOTHED = 4  # halvings spent on a step that converges but is rough
SINGULAR = 1e-10  # of the inertia matrix' largest eigenvalue
MAX_STEPS = 1_000_000  # an hour at the default step
CHUNK = 500  # steps planned together
MAX_SPEED = 200.0  # rad/s, m/s: ten times as fast as any arm
MAX_ERROR = 1.0  # rad, m: an arm this far from its motion does not follow it


def integrate(
    model: Model,
    motion: Motion,
    controller: Controller | None = None,
    extra_torque: ExtraTorque | None = None,
    step: float = STEP,
    temperature: Callable[[Array], Array] | None = None,
) -> Signals:
    """The true motion and drive torque of a model's robot that follows a planned motion, at every step [s].

    It starts in the motion's first state. ``controller``: by default ``PD.of_bandwidth``. ``extra_torque(time, q, v)``
    (n,) [N m|N] pushes the joints from outside. ``temperature(time)`` (N, n) [degC] for effects that depend on it. A step
    that does not converge is halved, up to eight times, one that is rough up to four times. Raises InputError for a
    motion beyond the robot's limits, a step too large, gains that make the arm run away, torques beyond the drives;
    NotSolvedError where a step does not converge.
    """
    check_step(step)
    if motion.duration > MAX_STEPS * step:
        raise InputError(
            f"simulation: a motion of {motion.duration:.4g} s is more than {MAX_STEPS} steps of {step:g} s; expected a shorter motion or a slower rate"
        )
    plant = Plant(model, temperature)
    _check(plant, motion)
    start = motion.states(np.zeros(1))
    law = (controller or PD.of_bandwidth(model, start.q[0])).law(plant, motion)
    stepper = Stepper(plant, law, _checked(extra_torque, plant.n))
    count = math.ceil(motion.duration / step - 1e-6)
    time: Array = step * np.arange(count + 1, dtype=float)
    q, v, a = np.empty((3, count + 1, plant.n))
    state = _initial(plant, stepper, start)
    q[0], v[0], a[0] = state.q, state.v, state.rates[-1, : plant.n]
    for first in range(0, count, CHUNK):
        ahead = time[first : min(first + CHUNK, count)]
        plans = law.plan((ahead[:, None] + step * NODES).ravel()).reshape(4, len(ahead), 3, plant.n)
        for k in range(first, first + len(ahead)):
            state = _advance(stepper, state, time[k], step, plans[:, k - first], HALVINGS)
            q[k + 1], v[k + 1], a[k + 1] = state.q, state.v, state.rates[-1, : plant.n]
            _check_tracking(time[k + 1], state, plans[0, k - first, -1])
    torque = np.concatenate([law.torque(law.plan(time[i : i + CHUNK]), q[i : i + CHUNK], v[i : i + CHUNK])
                             for i in range(0, count + 1, CHUNK)])  # fmt: skip
    _check_torque(model, time, torque)
    temperatures = None if temperature is None else temperature(time)
    return Signals(time, q, v, a, torque, temperatures, rate=1 / step, source="simulation")


def _advance(stepper: Stepper, state: State, time: float, h: float, plan: Array, halvings: int) -> State:
    after = stepper.step(state, time, h, plan, rough=halvings <= HALVINGS - SMOOTHED)
    if after is not None:
        return after
    if halvings == 0:
        raise NotSolvedError(
            f"simulation: does not converge at {time:.4f} s with a step of {h:.2g} s; is every link's inertia physical, does an external torque jump or grow too steeply?"
        )
    for part in (0.0, h / 2):
        half = stepper.law.plan(time + part + h / 2 * NODES)
        state = _advance(stepper, state, time + part, h / 2, half, halvings - 1)
    return state


def _initial(plant: Plant, stepper: Stepper, start: Signals) -> State:
    """The first state, with the acceleration that the drive's and the other torques give it."""
    z = np.zeros(plant.states)
    still = State(start.q[0], start.v[0], z, np.zeros((3, plant.n + plant.states)))
    state = stepper.step(still, 0.0, 0.0, stepper.law.plan(np.zeros(3)))
    if state is None:
        raise NotSolvedError("simulation: no acceleration fits the first state; is the inertia of every link physical?")
    return state


def _check_tracking(time: float, state: State, wanted: Array) -> None:
    error = state.q - wanted
    for values, limit, problem in (
        (state.v, MAX_SPEED, "reaches {:.3g} rad/s"),
        (error, MAX_ERROR, "is {:.3g} rad away from the motion"),
    ):
        j = int(np.argmax(np.abs(values)))
        if abs(values[j]) > limit:
            raise InputError(
                f"simulation: joint {j + 1} {problem.format(values[j])} at {time:.3f} s: the gains are unstable or too soft, or an effect or external torque is too large"
            )


def check_step(step: float) -> None:
    """Raises InputError for a step [s] that is not positive, or too large to resolve an arm's fast motions."""
    if not (math.isfinite(step) and 0 < step <= LONGEST_STEP):
        raise InputError(f"simulation: step {step:g} s is too large or not positive, expected at most {LONGEST_STEP} s")


def _check(plant: Plant, motion: Motion) -> None:
    broken = motion.violations(plant.robot)
    if broken:
        more = f" (and {len(broken) - 1} more)" if len(broken) > 1 else ""
        raise InputError(f"trajectory: {broken[0]}{more}; expected a motion inside the limits of {plant.robot.name}")
    for t in np.linspace(0, motion.duration, 20):
        M = plant.inertia(motion.states(np.array([t])).q[0])
        values = np.linalg.eigvalsh(M)
        if values[0] <= SINGULAR * values[-1]:
            raise InputError(
                f"model: its inertia matrix is not positive at {t:.2f} s of the motion; expected rigid bodies as links (identify with method='physical') or rotor inertia"
            )


def _check_torque(model: Model, time: Array, torque: Array) -> None:
    over = np.abs(torque) > model.robot.torque_limit
    if over.any():
        k, j = np.argwhere(over)[0]
        raise InputError(
            f"simulation: joint {j + 1} would need {torque[k, j]:.4g} N m at {time[k]:.3f} s, its drive gives {model.robot.torque_limit[j]:.4g} N m; use a slower motion or softer gains"
        )


def _checked(extra: ExtraTorque | None, n: int) -> ExtraTorque | None:
    if extra is None:
        return None

    def torque(time: float, q: Array, v: Array) -> Array:
        value = np.asarray(extra(time, q, v), dtype=float)
        if value.shape != (n,) or not np.isfinite(value).all():
            raise InputError(f"extra_torque gave {value} at {time:.4f} s, expected {n} finite numbers [N m]")
        return value

    return torque
