"""The UR10e: three runs are fitted and diagnosed, a fourth is replayed in both simulators."""

from __future__ import annotations

from functools import lru_cache

from kept import UR10E_COLUMNS, UR10E_GAINS, need_data

import physident as pid
from physident.replay.replay import replay

FITTED = ("06-20sec_10harm", "10-30sec_12harm", "12-40sec_12harm")
HELD_OUT = "12-50sec_12harm"


@lru_cache(maxsize=1)
def models() -> tuple[pid.Estimate, pid.Estimate, list[pid.Recording], list[pid.Recording]]:
    """The model before and after the diagnosis, the fitted recordings and the one held out."""
    folder = need_data("ur10e")
    paths = [str(folder / f"ur-20_02_{name}.csv") for name in (*FITTED, HELD_OUT)]
    recordings = pid.load_recordings(paths, UR10E_COLUMNS, UR10E_GAINS)
    before = pid.identify(pid.load_robot(folder / "ur10e.urdf"), recordings[:3], method="physical")
    found = pid.diagnose_motion(before, recordings[:3])
    assert found.estimate is not None
    return before, found.estimate, recordings[:3], recordings[3:]


def study() -> tuple[dict, list[str]]:
    before, after, _, held_out = models()
    results, rows = {}, []
    for simulator in ("mujoco", "physident"):
        result = replay(before, after, held_out, simulator).replay
        results[simulator] = result.as_dict() | {"recordings": [HELD_OUT]}
        rows += [*[row for row in repr(result).splitlines() if not row.startswith(("before:", "after:"))], ""]
    return results, rows[:-1]
