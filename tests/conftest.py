"""Shared fixtures: robots, and the folder of real recordings where there is one."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import physident as pid
from physident.processes import VARIABLE
from tests.opened import record_healthy

ROOT = Path(__file__).resolve().parents[1]
UR10E_COLUMNS = "time=0,q=1:7,dq=7:13,current=13:19"
UR10E_GAINS = (14.87, 13.26, 11.13, 10.62, 11.03, 11.47)  # N m/A
UR5_GAINS = (10.7, 10.7, 10.7, 10.2, 10.2, 10.2)  # N m/A

if "PYTEST_XDIST_WORKER" in os.environ:  # each worker has a processor; tests of several processes ask for them
    os.environ.setdefault(VARIABLE, "1")


@pytest.fixture(scope="session")
def data() -> Path:
    """The folder of real recordings; skips the test where it is absent."""
    path = Path(os.environ.get("PHYSIDENT_DATA", ROOT / ".." / "shared" / "data"))
    if not path.is_dir():
        pytest.skip(f"no real recordings in {path} (set PHYSIDENT_DATA)")
    return path


@pytest.fixture(scope="session")
def ur5() -> pid.Robot:
    return pid.load_robot("ur5")


@pytest.fixture(scope="session")
def healthy_runs(tmp_path_factory: pytest.TempPathFactory) -> list[pid.Recording]:
    """Four recordings of one healthy arm."""
    return record_healthy(tmp_path_factory.mktemp("healthy"))


@pytest.fixture(scope="session")
def healthy_estimate(ur5: pid.Robot, healthy_runs: list[pid.Recording]) -> pid.Estimate:
    """The model of the first two."""
    return pid.identify(ur5, healthy_runs[:2])
