# fast: one minute
"""How fast and how exact is the simulated arm, alone, in parallel, and beside other integrators and engines?"""

from __future__ import annotations

import os
import resource

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # matrices of six joints: threads only wait for each other

import sys
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from kept import keep

import physident as pid
from physident.effects.friction import CoulombFriction, ViscousFriction
from physident.effects.inertia import RigidBody, RotorInertia
from physident.simulation.controllers import PD, ComputedTorque, Released
from physident.simulation.integrate import integrate
from physident.simulation.plant import Instants, Plant
from physident.simulation.sensors import Sensors
from physident.simulation.simulate import Simulation, simulate, simulate_many

ROTOR = np.array([0.9, 0.8, 0.6, 0.2, 0.2, 0.2])  # kg m^2
VISCOUS = np.array([6.0, 6.0, 4.0, 2.0, 2.0, 1.0])  # N m s/rad
COULOMB = np.array([8.0, 8.0, 6.0, 2.0, 2.0, 1.5])  # N m
STEPS = (0.008, 0.004, 0.002, 0.001)  # s
EXACT = 0.0005  # s
RECORDINGS = 16
NARROW = 1e-5  # rad/s
ENGINE_STEPS = (1e-4, 2.5e-5)  # s


def arm(smoothing: float = 0.01) -> pid.Model:
    """The UR5 of all the comparisons."""
    robot = pid.load_robot("ur5")
    effects = (RigidBody(), RotorInertia(), ViscousFriction(), CoulombFriction(smoothing=smoothing))
    return pid.Model(robot, effects, np.concatenate([robot.nominal, ROTOR, VISCOUS, COULOMB]))


def timed(run: Callable[[], Any]) -> tuple[Any, float]:
    """What it returns, and the processor's seconds it took."""
    start = time.process_time()
    result = run()
    return result, time.process_time() - start


def one_minute(model: pid.Model) -> dict[str, float]:
    """Seconds of a 60 s recording at 125 Hz at the default step: of the processor, and on the wall."""
    motion = pid.random_trajectory(model.robot, seed=0, duration=60.0)
    start = time.perf_counter()
    _, processor = timed(lambda: simulate(model, motion))
    return {"processor": processor, "wall": time.perf_counter() - start}


def steps(model: pid.Model, motion: pid.Trajectory, exact: pid.Signals) -> dict[str, dict[str, float]]:
    """Seconds and largest errors of position and torque for each step."""
    found = {}
    for step in STEPS:
        states, seconds = timed(lambda step=step: integrate(model, motion, step=step))
        found[f"step {1e3 * step:g} ms"] = {
            "seconds": seconds,
            **errors(states.q, drive(states), exact, round(step / EXACT)),
        }
    return found


def libraries(model: pid.Model, motion: pid.Trajectory, exact: pid.Signals) -> dict[str, dict[str, float]]:
    """The same with SciPy's stiff integrators."""
    plant, n = Plant(model), model.robot.n
    law = PD.of_bandwidth(model, exact.q[0]).law(plant, motion)

    def rate(t: float, y: np.ndarray) -> np.ndarray:
        q, v = y[:n], y[n:]
        still = np.zeros(n)
        load = plant.inertial(q, v, still)
        at = Instants(np.array([t]), q[None], v[None], still[None], load[None], np.zeros((0, 1)))
        push = law.torque(law.plan(np.array([t])), q, v)[0] - load - plant.torque(at)[0]
        return np.concatenate([v, np.linalg.solve(plant.inertia(q), push)])

    found = {}
    start = np.concatenate([exact.q[0], exact.v[0]])
    grid = exact.time[::16]
    for method in ("LSODA", "Radau"):
        solved, seconds = timed(
            lambda method=method: solve_ivp(
                rate, (0, grid[-1]), start, method, grid, rtol=1e-6, atol=1e-8, max_step=0.02
            )
        )
        q, v = solved.y[:n].T, solved.y[n:].T
        found[f"scipy {method}"] = {"seconds": seconds, **errors(q, law.torque(law.plan(grid), q, v), exact, 16)}
    return found


def errors(q: np.ndarray, torque: np.ndarray, exact: pid.Signals, every: int) -> dict[str, float]:
    """Largest errors of position [rad] and torque [N m]."""
    return {
        "q": float(np.abs(q - exact.q[::every]).max()),
        "torque": float(np.abs(torque - drive(exact)[::every]).max()),
    }


def parallel(model: pid.Model) -> dict[str, dict[str, float]]:
    """Seconds for some recordings of 20 s, in one process and in one for each core: on the wall, and of the processors.

    The load before tells how many other programs shared the cores.
    """
    sensors = Sensors(encoder_step=5e-5, velocity_noise=1e-3, torque_noise=1.0)
    runs = [
        Simulation(model, pid.random_trajectory(model.robot, seed, duration=20.0), sensors=sensors, seed=seed)
        for seed in range(RECORDINGS)
    ]
    found = {}
    for processes in (1, os.cpu_count() or 1):
        load, start, used = os.getloadavg()[0], time.perf_counter(), children_seconds()
        simulate_many(runs, processes)
        wall = time.perf_counter() - start
        found[f"{processes}"] = {"wall": wall, "processors": children_seconds() - used, "load_before": load}
    return found


def children_seconds() -> float:
    """Processor's seconds of all processes that ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def against_mujoco() -> dict[str, list[float]]:
    """Largest difference of a joint angle [rad] from MuJoCo after 2 s, three motions, for each of its steps."""
    mujoco: Any = import_module("mujoco")
    model = arm(NARROW)
    found: dict[str, list[float]] = {f"{step:g}": [] for step in ENGINE_STEPS}
    for seed in (1, 2, 3):
        motion = pid.random_trajectory(model.robot, seed, harmonics=3, base_frequency=0.2)
        planned = integrate(model, motion, ComputedTorque(), step=0.002)

        def torque(t: Any, planned: pid.Signals = planned) -> np.ndarray:
            return np.array([np.interp(t, planned.time, column) for column in drive(planned).T]).T

        none = np.zeros((6, 2))
        hold = pid.Trajectory(none, none, planned.q[0], 0.5, 2.0)
        ours = integrate(model, hold, Released(), lambda t, q, v, torque=torque: torque(t), step=0.002)
        for step in ENGINE_STEPS:
            engine = mujoco.MjModel.from_xml_string(model.robot.urdf)
            engine.opt.timestep, engine.opt.gravity, engine.opt.tolerance = step, model.robot.gravity, 1e-12
            engine.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
            engine.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
            engine.dof_armature[:], engine.dof_damping[:], engine.dof_frictionloss[:] = ROTOR, VISCOUS, COULOMB
            engine.dof_solref[:], engine.dof_solimp[:] = [2 * step, 1], [0.99, 0.999, 0.001, 0.5, 2]
            data = mujoco.MjData(engine)
            data.qpos = ours.q[0]
            for data.qfrc_applied[:] in torque(step * (np.arange(round(2 / step)) + 0.5)):
                mujoco.mj_step(engine, data)
            found[f"{step:g}"].append(float(np.abs(data.qpos - ours.q[-1]).max()))
    return found


def drive(states: pid.Signals) -> np.ndarray:
    """The drive's torque (N, n) [N m]."""
    assert states.torque is not None
    return states.torque


def main() -> None:
    model = arm()
    motion = pid.random_trajectory(model.robot, seed=0, duration=20.0)
    exact = integrate(model, motion, step=EXACT)
    minute = one_minute(model)
    methods = {**steps(model, motion, exact), **libraries(model, motion, exact)}
    many, engine = parallel(model), against_mujoco()
    results = {"minute": minute, "methods": methods, "parallel": many, "mujoco": engine}
    rows = [
        f"UR5, 60 s at 125 Hz, default step: {minute['processor']:.1f} s of the processor, {minute['wall']:.1f} s on the wall (asked: 6)",
        "",
        "20 s of motion         seconds   largest error of q [rad]   of the torque [N m]",
        *(f"{name:<20}   {m['seconds']:7.2f}   {m['q']:24.1e}   {m['torque']:19.1e}" for name, m in methods.items()),
        "",
        *(
            f"{RECORDINGS} recordings of 20 s, processes {p:>2}: {s['wall']:5.1f} s on the wall, {s['processors']:5.1f} s of the processors, load of others {s['load_before']:.1f}"
            for p, s in many.items()
        ),
        "",
        *(
            f"MuJoCo with a step of {float(step):.1e} s: largest angle differs by {', '.join(f'{x:.1e}' for x in d)} rad after 2 s"
            for step, d in engine.items()
        ),
    ]
    keep(Path(__file__).parent, results, "\n".join(rows))


if __name__ == "__main__":
    main()
