# fast: four simulated recordings a case, and real arms, two minutes
"""What does the error near zero speed cost: on a simulated arm that sticks, bristles or slides smoothly, and on real arms?"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy loads: small matrices, and a machine that is shared

import sys
from pathlib import Path
from typing import Any, get_args

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from kept import joint_row, keep

import physident as pid
from studies.dry_friction.arm import INSTRUMENTS, runs
from studies.dry_friction.real import real_arms
from tests.serial_arms import Kind

ALLOWED = {"clean": 1.0, "1e-3": 2.0, "5e-3": 4.0, "absent": 4.0}  # % on the arm that sticks


def main() -> None:
    rows = [
        "relative error [%] of all rows on an unseen recording of a simulated UR5, cutoff 5 Hz, default model",
        joint_row("friction, velocity noise", range(1, 7), 0),
    ]
    simulated: dict[str, Any] = {}
    for kind in get_args(Kind):
        for instrument in INSTRUMENTS:
            score, widths = simulated_score(kind, instrument)
            kept = {
                key: value for key, value in score.as_dict().items() if key != "recordings"
            }  # paths of this machine
            simulated[f"{kind}, {instrument}"] = {**kept, "smoothing": widths}
            rows.append(joint_row(f"{kind}, {instrument}", score.relative_all, 1))
    real = real_arms()
    rows += [
        "",
        "relative error [%] of all rows on real recordings that were not fitted",
        joint_row("arm", range(1, 7), 0),
    ]
    rows += [joint_row(name, values, 1) for name, values in real.items()]
    worst = {name: max(simulated[f"dry, {name}"]["relative_percent_all"]) for name in ALLOWED}
    rows.append(
        "arm that sticks, worst joint: " + ", ".join(f"{n} {w:.1f} (allowed {ALLOWED[n]:g})" for n, w in worst.items())
    )
    keep(Path(__file__).parent, {"simulated": simulated, "real": real}, "\n".join(rows))
    if any(worst[name] > ALLOWED[name] for name in ALLOWED):
        sys.exit("an error on the arm that sticks is larger than allowed")


def simulated_score(kind: Kind, instrument: str) -> tuple[pid.Score, list[float]]:
    """Score of the default model, identified from three recordings, on the fourth; and the widths of the sign it found."""
    recordings = [taken.recording for taken in runs(kind, instrument)]
    estimate = pid.identify(pid.load_robot("ur5"), recordings[:3])
    (coulomb,) = [e for e in estimate.model.effects if e.name == "coulomb_friction"]
    return pid.validate(estimate, recordings[3:]), list(vars(coulomb)["smoothing"])


if __name__ == "__main__":
    main()
