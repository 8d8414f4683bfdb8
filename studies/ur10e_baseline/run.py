# fast: real UR10e recordings, half a minute
"""How well do the five default effects predict a real UR10e that they were not fitted to?"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from kept import UR10E_COLUMNS, UR10E_GAINS, joint_row, keep, need_data

import physident as pid

REFERENCE = (8.2, 4.3, 4.2, 8.6, 12.8, 11.0)  # % relative error another implementation of the same method reached
ALLOWED = 0.1  # absolute, %


def main() -> None:
    data = need_data("ur10e")
    robot = pid.load_robot(data / "ur10e.urdf")
    runs = pid.load_recordings(str(data / "ur-20_02_*.csv"), columns=UR10E_COLUMNS, drive_gains=UR10E_GAINS)
    errors = {}
    for method in ("wls", "ols"):
        each = []
        for left_out in range(len(runs)):
            train = [run for i, run in enumerate(runs) if i != left_out]
            estimate = pid.identify(robot, train, method=method)
            each.append(pid.validate(estimate, [runs[left_out]]).relative_all)
        errors[method] = np.array(each)
    rows = [
        "relative error [%] on the run that was left out, cutoff 5 Hz, moving part; mean over eight runs",
        joint_row("joint", range(1, 7), 0),
        *(joint_row(f"{method}, five default effects", errors[method].mean(axis=0)) for method in errors),
        joint_row("reference for wls", REFERENCE, 1),
    ]
    rows += [joint_row(f"  wls, {Path(run.source).stem}", e) for run, e in zip(runs, errors["wls"], strict=True)]
    worst = float((errors["wls"].mean(axis=0) - REFERENCE).max())
    rows.append(f"wls lies at most {worst:+.2f} above the reference (allowed {ALLOWED:+.1f})")
    results = {
        "recordings": [Path(run.source).name for run in runs],
        "cutoff": 5.0,
        "wls": {"mean": errors["wls"].mean(axis=0).tolist(), "each": errors["wls"].tolist()},
        "ols": {"mean": errors["ols"].mean(axis=0).tolist()},
        "reference": REFERENCE,
        "worst_excess": worst,
    }
    keep(Path(__file__).parent, results, "\n".join(rows))
    if worst > ALLOWED:
        sys.exit("the reference is not reached")


if __name__ == "__main__":
    main()
