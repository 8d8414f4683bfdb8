"""Draws docs/pictures/session.png: a session of a real UR10e and its diagnosis, as it opens in the viewer.

The first of eight runs is kept from fitting and diagnosis, and shown. Needs the recordings that the studies use
(`PHYSIDENT_DATA`), about a minute, and a Vulkan driver, for which a processor will do (Debian: mesa-vulkan-drivers).
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from io import BytesIO
from pathlib import Path

import physident as pid

ROOT = Path(__file__).resolve().parents[1]
PICTURE = ROOT / "docs" / "pictures" / "session.png"
MENU, WIDTH = 36, 1600  # pixels
PORT = 19876
SETTLE = 12.0  # s until a slow computer has drawn every view


def main() -> None:
    """Fit seven runs, ask what is missing, and show the eighth."""
    sys.path.insert(0, str(ROOT / "studies"))
    from kept import UR10E_COLUMNS, UR10E_GAINS, need_data

    data = need_data("ur10e")
    robot = pid.load_robot(data / "ur10e.urdf")
    unseen, *runs = pid.load_recordings(str(data / "ur-20_02_*.csv"), columns=UR10E_COLUMNS, drive_gains=UR10E_GAINS)
    nominal = pid.identify(robot, runs)
    found = pid.diagnose_motion(nominal, runs, holdout=[unseen])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "session.rrd")
        pid.view({"identified": nominal}, unseen, found, to=path)
        draw(path)
    print(f"written: {PICTURE.relative_to(ROOT)}")


def draw(path: Path) -> None:
    """Open the session in a viewer without a window, and keep the picture of how it opens, without its menu."""
    from PIL import Image
    from rerun.experimental import ViewerClient

    os.environ["CI"] = "true"  # the viewer sends no statistics
    program = Path(sys.executable).with_name("rerun")
    with ViewerClient.spawn(headless=True, port=PORT, executable_path=str(program)) as viewer:
        viewer.open(str(path))
        time.sleep(SETTLE)
        picture = Image.open(BytesIO(viewer.take_screenshot())).convert("RGB")
    picture = picture.crop((0, MENU, *picture.size))
    picture = picture.resize((WIDTH, round(WIDTH * picture.height / picture.width)), Image.Resampling.LANCZOS)
    PICTURE.parent.mkdir(exist_ok=True)
    picture.save(PICTURE, optimize=True)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        draw(Path(sys.argv[1]))
    else:
        main()
