"""The recordings of real arms that tutorials and how-to pages are played with, as their drivers would have written them."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
BAGS = {"panda.db3": "panda_exciting_trajectory.db3"}
UR_LOGS = {  # the name in a page, and that of the UR10e's recording
    "monday.csv": "ur-20_02_05-20sec_8harm.csv",
    "tuesday.csv": "ur-20_02_06-20sec_10harm.csv",
    "wednesday.csv": "ur-20_02_10-20sec_7harm.csv",
    "loaded.csv": "ur-20_01_13-load_2600.csv",
}
NAMES = ("actual_q", "actual_qd", "actual_current")


def data_folder() -> Path:
    """The folder of real recordings."""
    return Path(os.environ.get("PHYSIDENT_DATA", ROOT / ".." / "shared" / "data"))


def put(name: str, folder: Path) -> None:
    """Write a recording into a folder under the name that the pages give it; raises KeyError for another name."""
    if name in BAGS:
        shutil.copyfile(data_folder() / "rosbag2" / BAGS[name], folder / name)
        return
    rows = np.genfromtxt(data_folder() / "ur10e" / UR_LOGS[name], delimiter=",", usecols=range(19))
    head = " ".join(["timestamp", *(f"{channel}_{joint}" for channel in NAMES for joint in range(6))])
    np.savetxt(folder / name, rows, fmt="%.8g", header=head, comments="")
