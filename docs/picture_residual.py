"""Draws docs/pictures/residual.png: what a model leaves of a real UR10e's torque before and after its diagnosis.

The first of eight runs is kept from fitting and diagnosis, and drawn. Needs the recordings that the studies use
(`PHYSIDENT_DATA`), and about a minute.
"""

from __future__ import annotations

import sys
import textwrap
from pathlib import Path

import numpy as np

import physident as pid
from physident.graphics import style
from physident.validation.comparison import Pair, predict_pair

ROOT = Path(__file__).resolve().parents[1]
PICTURE = ROOT / "docs" / "pictures" / "residual.png"
WIDTH = 125  # characters of the title


def main() -> None:
    """Fit seven runs, ask what is missing, and draw the eighth."""
    sys.path.insert(0, str(ROOT / "studies"))
    from kept import UR10E_COLUMNS, UR10E_GAINS, need_data

    data = need_data("ur10e")
    robot = pid.load_robot(data / "ur10e.urdf")
    unseen, *runs = pid.load_recordings(str(data / "ur-20_02_*.csv"), columns=UR10E_COLUMNS, drive_gains=UR10E_GAINS)
    found = pid.diagnose_motion(pid.identify(robot, runs), runs, holdout=[unseen])
    after = None if found.estimate is None else found.estimate.model
    pair = predict_pair(found.model, after, [unseen], found.filter, found.drive_gains)
    title = f"UR10e, a run that nobody fitted. {found.headline}"
    draw(pair, robot, f"{title} {found.remainder}")
    print(found)
    print(f"written: {PICTURE.relative_to(ROOT)}")


def draw(pair: Pair, robot: pid.Robot, title: str) -> None:
    """All joints, two beside one another, so that six fit a README's width."""
    fig, axes = style.figure((robot.n + 1) // 2, 2, size=(5.0, 1.35), sharex=True)
    time = np.arange(len(pair.before.time)) / pair.before.rate
    for j, axis in enumerate(axes.ravel()[: robot.n]):
        for p, name, colour in zip(
            pair.both, ("model as it was", "extended model"), (style.AS_IT_WAS, style.EXTENDED), strict=False
        ):
            axis.plot(time, p.residual[:, j], color=colour, label=name, linewidth=1.0)
        sizes = [float(p.rms[j]) for p in pair.both]
        axis.set_title(f"joint {j + 1}: {' to '.join(f'{s:.3g}' for s in sizes)} N m RMS", fontsize=9, loc="left")
        axis.set_ylabel("residual\n[N m]")
    for axis in axes[-1]:
        axis.set_xlabel("time in motion [s]")
    fig.suptitle("\n".join(textwrap.wrap(title, WIDTH)), fontsize=9, x=0.01, ha="left", fontweight="bold")
    fig.legend(*axes[0, 0].get_legend_handles_labels(), ncols=2, loc="outside lower right", frameon=False)
    PICTURE.parent.mkdir(exist_ok=True)
    style.save(fig, PICTURE)


if __name__ == "__main__":
    main()
