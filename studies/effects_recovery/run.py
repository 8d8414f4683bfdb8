"""Does naming an effect in `identify` give its parameters back, when an independent plant hides it strongly?"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
import numpy as np
from kept import keep

import physident as pid
from physident.effects.catalogue import DEFAULT_EFFECTS
from physident.identifiability.base_parameters import random_motion
from tests.exact_friction import exact_arm
from tests.plant import Arm, Sensors, hide, multisine, point_to_point, record

PERCENT = 5.0  # asked of a parameter, unless its 95 % interval holds the truth
SHAPE_PERCENT = 10.0
SEEDS = (11, 12, 13)


@dataclass(frozen=True)
class Case:
    """An effect, where and how strongly the plant hides it, and what `identify` is told."""

    effect: str
    joints: tuple[int, ...]
    magnitude: float
    shape: dict[str, Any] = field(default_factory=dict)
    settings: dict[str, Any] = field(default_factory=dict)
    cutoff: float = 5.0
    field: str = ""  # the shape parameter that identify must find
    shape_truth: float = 0.0


CASES = (
    Case("rotor_inertia", (3,), 2.0),
    Case("viscous_friction", (2,), 9.0),
    Case("coulomb_friction", (4,), 3.0),
    Case("friction_asymmetry", (1,), 5.0),
    Case("stribeck_friction", (2,), 8.0, {"stribeck_speed": 0.08}, field="velocity", shape_truth=0.08),
    Case("nonlinear_viscous_friction", (1,), 12.0, {"exponent": 0.5}, field="exponent", shape_truth=0.5),
    Case("load_dependent_friction", (2,), 0.2),
    Case("presliding_hysteresis", (3,), 600.0, {"slip": 0.02}, field="distance", shape_truth=0.02),
    Case("warm_up", (1,), 0.8, {"time": 8.0}, field="time_constant", shape_truth=8.0),
    Case("coupled_friction", (5, 6), 3.0, {"viscous": 2.0}),
    Case("torque_constant", (2,), 0.2),
    Case("torque_offset", (3,), 4.0),
    Case("time_delay", (), 0.03),
    Case("torque_ripple", (3,), 4.0, {"order": 12.0, "phase": 0.5}, cutoff=8.0, field="order", shape_truth=12.0),
    Case("joint_spring", (4,), 3.0),
    Case("joint_elasticity", (2,), 1e-4),
    Case("payload", (), 3.0),
    Case("link_inertia", (3,), 1.5),
    Case("gravity_tilt", (), 0.08, {"direction": 0.7}),
    Case("joint_zero_offset", (2,), 0.05),
    Case("contact", (), 30.0, {"start": 5.0, "end": 7.0, "direction": (0.3, 0.5, 1.0)}),
)


def truths(case: Case, arm: Arm) -> dict[str, float]:
    """The true values of the effect's parameters, by column name."""
    j = case.joints[0] if case.joints else 0
    ordinary = Arm()
    single = {
        "rotor_inertia": arm.drives.rotor_inertia,
        "viscous_friction": arm.friction.viscous,
        "coulomb_friction": arm.friction.coulomb,
    }
    if case.effect in single:
        return {f"{case.effect}_{j}": float(single[case.effect][j - 1])}
    if case.effect == "warm_up":
        dry, viscous = ordinary.friction.coulomb[j - 1], ordinary.friction.viscous[j - 1]
        return {f"warm_up_coulomb_{j}": case.magnitude * dry, f"warm_up_viscous_{j}": case.magnitude * viscous}
    if case.effect == "coupled_friction":
        return {"coupled_friction_coulomb_5_6": case.magnitude, "coupled_friction_viscous_5_6": case.shape["viscous"]}
    if case.effect == "torque_ripple":
        A, phase = case.magnitude, case.shape["phase"]
        return {f"torque_ripple_sin_{j}": A * np.cos(phase), f"torque_ripple_cos_{j}": A * np.sin(phase)}
    if case.effect == "gravity_tilt":
        return {"gravity_tilt_x": float(arm.gravity[0]), "gravity_tilt_y": float(arm.gravity[1])}
    if case.effect == "contact":
        force = case.magnitude * np.array(case.shape["direction"])
        return {f"contact_F{axis}_5s": float(f) for axis, f in zip("xyz", force, strict=True)}
    return {case.effect if case.effect == "time_delay" else f"{case.effect}_{j}": case.magnitude}


def recordings(case: Case, arm: Arm, folder: Path) -> list[pid.Recording]:
    """Three recordings of 20 s: two random motions and one from point to point."""
    motions = (multisine(SEEDS[0]), multisine(SEEDS[1], speed=1.3), point_to_point(SEEDS[2]))
    if case.effect == "torque_ripple":
        motions = tuple(multisine(seed, speed=0.6) for seed in SEEDS)  # slow enough for order 12 to pass the filter
    paths = []
    for motion, seed in zip(motions, SEEDS, strict=True):
        paths.append(folder / f"{seed}.csv")
        record(arm, motion, Sensors(), seed=seed).write_csv(paths[-1])
    return pid.load_recordings(paths)


def named(case: Case, runs: list[pid.Recording]) -> list[str | pid.Effect]:
    """What `identify` is told: the default effects and the hidden one, its joints and nothing of its values."""
    settings = dict(case.settings)
    if case.effect == "contact":
        settings |= {"intervals": ((5.0, 7.0),)}
    if case.effect in DEFAULT_EFFECTS:
        return list(DEFAULT_EFFECTS)
    return [*DEFAULT_EFFECTS, pid.CATALOGUE[case.effect](joints=case.joints or None, **settings)]


def torque_of_change(case: Case, robot: pid.Robot, arm: Arm, estimate: pid.Estimate) -> list[dict[str, Any]]:
    """For effects inside the rigid body's columns: the torque of the change, found against true, on an unseen motion."""
    motion = random_motion(robot, seed=99)
    truth = pid.Model(robot, pid.make_effects(["rigid_body"]), arm.links.ravel()).torque(motion)
    plain = pid.Model(robot, pid.make_effects(["rigid_body"]), Arm().links.ravel()).torque(motion)
    rigid = [e for e in estimate.model.effects if e.name in ("rigid_body", "rotor_inertia", case.effect)]
    kept = [i for i, c in enumerate(estimate.model.columns) if c.effect in {e.name for e in rigid}]
    rotor = Arm().drives.rotor_inertia * motion.a
    found = pid.Model(robot, tuple(rigid), estimate.theta[kept]).torque(motion) - rotor - plain
    change = truth - plain
    error = 100 * float(np.linalg.norm(found - change) / np.linalg.norm(change))
    return [
        {"parameter": "torque of the change [%]", "truth": 100.0, "found": 100.0 - error, "std": None, "percent": error}
    ]


def run_case(case: Case, robot: pid.Robot, folder: Path) -> list[dict[str, Any]]:
    """The rows of one case."""
    arm = hide(exact_arm(), case.effect, case.joints, case.magnitude, **case.shape)
    if case.effect == "contact":
        runs = recordings(case, exact_arm(), folder)[:2]
        record(arm, multisine(SEEDS[2]), Sensors(), seed=SEEDS[2]).write_csv(folder / "touched.csv")
        touched = pid.load_recording(folder / "touched.csv")
        runs.append(touched)
        effects = [*DEFAULT_EFFECTS, pid.CATALOGUE["contact"](intervals=((5.0, 7.0),), recording=touched.sha256)]
    else:
        runs = recordings(case, arm, folder)
        effects = named(case, runs)
    estimate = pid.identify(robot, runs, effects, filter=pid.Filter(case.cutoff))
    rows: list[dict[str, Any]] = []
    if case.effect in ("payload", "link_inertia"):
        rows = torque_of_change(case, robot, arm, estimate)
    else:
        for name, truth in truths(case, arm).items():
            (i,) = [i for i, c in enumerate(estimate.model.columns) if c.name == name]
            found, std = float(estimate.theta[i]), float(estimate.standard_errors[i])
            percent = 100 * abs(found - truth) / abs(truth)
            rows.append({"parameter": name, "truth": truth, "found": found, "std": std, "percent": percent})
    for row in rows:
        inside = row["std"] is not None and abs(row["found"] - row["truth"]) <= 1.96 * row["std"]
        row["passed"] = bool(row["percent"] <= PERCENT or inside)
    if case.field:
        (found,) = getattr(estimate.model.effects[-1], case.field)
        std = estimate.shape_parameters[0].std if estimate.shape_parameters else None
        percent = 100 * abs(found - case.shape_truth) / case.shape_truth
        shape = {"parameter": case.field, "truth": case.shape_truth, "found": found, "std": std, "percent": percent}
        rows.append(shape | {"passed": bool(percent <= SHAPE_PERCENT)})
    return [{"effect": case.effect, "joints": list(case.joints)} | row for row in rows]


def main() -> None:
    robot = pid.load_robot("ur5")
    rows: list[dict[str, Any]] = []
    chosen = [case for case in CASES if not sys.argv[1:] or case.effect in sys.argv[1:]]
    lines = [f"{'effect':<28}{'joints':<8}{'parameter':<32}{'truth':>11}{'found':>11}{'std':>10}{'off %':>8}"]
    for case in chosen:
        with tempfile.TemporaryDirectory() as folder:
            for row in run_case(case, robot, Path(folder)):
                rows.append(row)
                std = "" if row["std"] is None else f"{row['std']:.3g}"
                joints = ",".join(map(str, row["joints"])) or "all"
                lines.append(
                    f"{row['effect']:<28}{joints:<8}{row['parameter']:<32}{row['truth']:>11.4g}{row['found']:>11.4g}"
                    f"{std:>10}{row['percent']:>8.1f}" + ("" if row["passed"] else "  <-")
                )
                print(lines[-1], flush=True)
    passed = sum(row["passed"] for row in rows)
    lines.append(
        f"{passed} of {len(rows)} within {PERCENT:g} % or the stated interval (shapes within {SHAPE_PERCENT:g} %)"
    )
    if not sys.argv[1:]:
        keep(Path(__file__).parent, {"rows": rows, "passed": passed, "of": len(rows)}, "\n".join(lines))


if __name__ == "__main__":
    main()
