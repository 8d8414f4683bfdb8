# fast: simulated UR5 and real UR10e recordings, one minute
"""How well is a load found: on an arm whose truth is known, and on a real one with a load of 2.6 kg?"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from kept import UR10E_COLUMNS, UR10E_GAINS, keep, need_data

import physident as pid
from physident.simulation.sensors import Sensors
from physident.simulation.simulate import Simulation, simulate_many

EFFECTS = ("rigid_body", "rotor_inertia", "viscous_friction", "coulomb_friction")
VISCOUS = (9.0, 9.0, 6.0, 2.5, 2.0, 1.5)  # N m s/rad
COULOMB = (7.7, 8.3, 7.8, 1.4, 2.0, 2.1)  # N m
SENSORS = Sensors(encoder_step=2 * np.pi / 2**17, velocity_noise=1e-3, torque_noise=(1.5, 2.0, 1.2, 0.3, 0.3, 0.25))
MASSES = (1.0, 2.6, 5.0)  # kg
ARMS = 8
DURATION = 20.0  # s
CENTRE_SPREAD = 0.06  # m, standard deviation of each coordinate of the centre of mass
RADIUS = 0.05  # m, radius of gyration
ALLOWED_MASS, ALLOWED_CENTRE = 1.0, 3.0  # %, mm, for the load of 2.6 kg
KNOWN = 2.6  # kg
OWNER_GAINS = (10.00, 10.70, 8.46, 9.00, 9.48, 10.12)  # N m/A, the data owner's


def main() -> None:
    data = need_data("ur10e")
    simulated = simulated_loads()
    real = real_load(data)
    rows = [
        f"simulated UR5, {ARMS} arms identified from two unloaded noisy recordings, load from {DURATION:g} s of a random motion",
        "load [kg]   mass error [%] rms  worst   centre error [mm] rms  worst   95 % intervals that hold: mass  centre  inertia",
    ]
    for mass, s in simulated.items():
        rows.append(
            f"{mass:>9}{s['mass_rms_percent']:21.2f}{s['mass_worst_percent']:7.2f}{s['centre_rms_mm']:24.2f}{s['centre_worst_mm']:7.2f}"
            f"{s['mass_covered']:31d}/{ARMS}{s['centre_covered']:5d}/{3 * ARMS}{s['moments_covered']:6d}/{3 * ARMS}"
        )
    rows += ["", f"real UR10e, a load of {KNOWN} kg; arm identified from the eight unloaded runs of February"]
    rows += ["gains          mass [kg]  interval         too heavy [%]  mass seen by joints 2, 3, 4, 5 alone [kg]"]
    for name, r in real.items():
        low, high = r["mass_interval_kg"]
        alone = ", ".join(f"{pair[0]:.2f}" for pair in r["mass_seen_by_joint_kg"][1:5])
        heavy = 100 * (r["mass_kg"] / KNOWN - 1)
        rows.append(f"{name:<12}{r['mass_kg']:12.2f}  [{low:.2f}, {high:.2f}]{heavy:19.1f}  {alone}")
    results = {
        "duration_s": DURATION,
        "arms": ARMS,
        "simulated": simulated,
        "real": real,
        "allowed": {"mass_percent": ALLOWED_MASS, "centre_mm": ALLOWED_CENTRE},
    }
    keep(Path(__file__).parent, results, "\n".join(rows))
    reached = simulated["2.6"]
    if reached["mass_worst_percent"] > ALLOWED_MASS or reached["centre_worst_mm"] > ALLOWED_CENTRE:
        sys.exit("a load of 2.6 kg is not found as well as asked")


def simulated_loads() -> dict[str, dict[str, Any]]:
    """Errors and coverage for each mass over all arms."""
    robot = pid.load_robot("ur5")
    free = pid.Model.nominal(robot, EFFECTS)
    free = replace(free, theta=np.concatenate([free.theta[:-12], VISCOUS, COULOMB]))
    loads = {(mass, k): load(mass, k) for mass in MASSES for k in range(ARMS)}
    tasks = [task(free, 100 * k + part) for k in range(ARMS) for part in range(2)]
    for (_, k), phi in loads.items():
        theta = np.array(free.theta)
        theta[10 * (robot.n - 1) : 10 * robot.n] += phi
        tasks.append(task(replace(free, theta=theta), 100 * k + 2))
    recordings = simulate_many(tasks)
    arms = [pid.identify(robot, recordings[2 * k : 2 * k + 2], EFFECTS) for k in range(ARMS)]
    carried = dict(zip(loads, recordings[2 * ARMS :], strict=True))
    found = {key: pid.identify_payload(arms[key[1]], [carried[key]]) for key in loads}
    return {f"{mass:g}": score([(found[mass, k], loads[mass, k]) for k in range(ARMS)]) for mass in MASSES}


def task(model: pid.Model, seed: int) -> Simulation:
    motion = pid.random_trajectory(model.robot, seed=seed, duration=DURATION)
    return Simulation(model, motion, sensors=SENSORS, seed=seed)


def load(mass: float, seed: int) -> np.ndarray:
    """Ten parameters of a ball of this mass at a random place."""
    c = CENTRE_SPREAD * np.random.default_rng(seed).normal(size=3)
    tensor = mass * ((2 * RADIUS**2 + c @ c) * np.eye(3) - np.outer(c, c))
    return np.array([mass, *(mass * c), *tensor[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]])


def score(pairs: list[tuple[pid.Payload, np.ndarray]]) -> dict[str, Any]:
    mass = np.array([100 * (found.mass / true[0] - 1) for found, true in pairs])
    centre = 1000 * np.array([found.centre - true[1:4] / true[0] for found, true in pairs])
    held = [found.mass_interval[0] < true[0] < found.mass_interval[1] for found, true in pairs]
    held_centre = [
        (found.centre_interval[:, 0] < true[1:4] / true[0]) & (found.centre_interval[:, 1] > true[1:4] / true[0])
        for found, true in pairs
    ]
    moment = 2 * RADIUS**2  # of a ball about any axis through its centre, for each kilogram
    held_moments = [
        (found.moment_interval[:, 0] < moment * true[0]) & (found.moment_interval[:, 1] > moment * true[0])
        for found, true in pairs
    ]
    return {
        "mass_rms_percent": float(np.sqrt((mass**2).mean())),
        "mass_worst_percent": float(np.abs(mass).max()),
        "centre_rms_mm": float(np.sqrt((centre**2).mean())),
        "centre_worst_mm": float(np.abs(centre).max()),
        "mass_covered": int(sum(held)),
        "centre_covered": int(np.sum(held_centre)),
        "moments_covered": int(np.sum(held_moments)),
    }


def real_load(data: Path) -> dict[str, dict[str, Any]]:
    """The load of 2.6 kg with both published sets of drive gains."""
    robot = pid.load_robot(data / "ur10e.urdf")
    result = {}
    for name, gains in (("literature", UR10E_GAINS), ("data owner", OWNER_GAINS)):
        free = pid.load_recordings(str(data / "ur-20_02_*.csv"), UR10E_COLUMNS, gains)
        carried = pid.load_recordings(data / "ur-20_01_13-load_2600.csv", UR10E_COLUMNS, gains)
        found = pid.identify_payload(pid.identify(robot, free), carried).as_dict()
        result[name] = found | {"recordings": [Path(path).name for path in found["recordings"]]}
    return result


if __name__ == "__main__":
    main()
