"""Random ordinary arms, their motions and recordings, kept outside the project for the next run."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import physident as pid
from physident.effects.catalogue import DEFAULT_EFFECTS
from tests.exact_friction import exact_arm
from tests.plant import Arm, Drives, Friction, Multisine, PointToPoint, Sensors, multisine, point_to_point, record

Array = NDArray[np.float64]
CACHE = Path(os.environ.get("PHYSIDENT_CACHE", Path.home() / ".cache" / "physident")) / "blind_trials"
DURATION = 20.0  # s
FILTER = pid.Filter(8.0)  # as for real recordings of a UR5 at 125 Hz
STEP = 2e-3  # s: torque after the filter is then right to a fiftieth of the instruments' noise
HEALTHY = 900_000_000  # seeds of motions from here on belong to healthy arms
ARMS = 12  # of a set, each identified on three recordings


def ordinary(seed: int) -> Arm:
    """A UR5 whose links, rotors and friction differ from the nominal ones as those of real arms do; only how friction turns
    near zero speed is just as the estimator has it."""
    rng = np.random.default_rng([seed, 101])
    arm = Arm()
    friction = Friction(
        viscous=arm.friction.viscous * rng.uniform(0.6, 1.5, 6), coulomb=arm.friction.coulomb * rng.uniform(0.6, 1.5, 6)
    )
    drives = Drives(
        rotor_inertia=arm.drives.rotor_inertia * rng.uniform(0.7, 1.3, 6), torque_offset=rng.normal(0, 0.2, 6)
    )
    return exact_arm(replace(arm, links=arm.links * rng.uniform(0.85, 1.15, (6, 1)), friction=friction, drives=drives))


def nominal(arm: Arm) -> pid.Model:
    """The model that knows an ordinary arm perfectly."""
    robot = pid.load_robot("ur5")
    effects = pid.make_effects(DEFAULT_EFFECTS)
    own = {
        "rigid_body": arm.links.ravel(),
        "rotor_inertia": arm.drives.rotor_inertia,
        "viscous_friction": arm.friction.viscous,
        "coulomb_friction": arm.friction.coulomb,
        "torque_offset": arm.drives.torque_offset,
    }
    return pid.Model(robot, effects, np.concatenate([own[effect.name] for effect in effects]))


@dataclass(frozen=True, eq=False)
class Taken:
    """A recording as a user has it, and the torque that what is hidden adds (N, n) [N m] at its rows."""

    recording: pid.Recording
    hidden: Array

    @property
    def alone(self) -> pid.Recording:
        """The same motion with nothing but the hidden torque."""
        return replace(self.recording, effort=self.hidden)

    @property
    def without(self) -> pid.Recording:
        """The same recording with the hidden torque taken away."""
        return replace(self.recording, effort=self.recording.effort - self.hidden)


def take(path: Path, arm: Arm, seed: int, without: Arm) -> Taken:
    """The recording of a motion that the seed draws, from disk where it was made before."""
    csv, truth = path.with_suffix(".csv"), path.with_suffix(".npy")
    if not truth.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        made = record(arm, motion(seed), Sensors(), seed, without=without, step=STEP)
        made.write_csv(csv)
        np.save(truth, made.with_effect - made.without_effect)
    return Taken(pid.load_recording(csv), np.load(truth))


def motion(seed: int) -> Multisine | PointToPoint:
    """A random motion; ten seeds in a row share its kind and pace, as the recordings of one day do."""
    rng = np.random.default_rng([seed // 10, 103])
    speed = float(rng.uniform(0.7, 1.3))
    return (point_to_point if rng.random() < 0.3 else multisine)(seed, speed=speed, duration=DURATION)


@lru_cache
def identified(group: int, number: int) -> tuple[Arm, pid.Estimate]:
    """An ordinary arm of a set, and what was identified when it was healthy."""
    seed = 10_000 * group + number
    arm = ordinary(seed)
    folder = CACHE / f"set{group}" / f"arm{number}"
    # each of another kind or pace
    runs = [take(folder / str(k), arm, HEALTHY + 100 * seed + 10 * k, arm).recording for k in range(3)]
    return arm, pid.identify(pid.load_robot("ur5"), runs, filter=FILTER)
