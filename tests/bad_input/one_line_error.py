"""What bad input must give: exit code 2, one line that names the input, and no change of any file."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from physident.cli import run

MEMORY = 3 << 30  # bytes of address space: libraries alone map about half of it


def fails(capfd: pytest.CaptureFixture, folder: Path, arguments: list[str], says: str) -> None:
    """The command fails with one line on standard error that matches, and leaves the folder as it was."""
    before = contents(folder)
    capfd.readouterr()
    code = run(arguments)
    out, err = capfd.readouterr()  # of the file descriptors: what C++ libraries print is seen too
    assert_one_line(code, out, err, says)
    assert contents(folder) == before


def refused_recording(capfd: pytest.CaptureFixture, folder: Path, name: str, says: str) -> None:
    """Looking at a recording fails as identifying from it does."""
    fails(capfd, folder, ["inspect", name], says)
    fails(capfd, folder, ["identify", name, "--robot", "ur5", "--out", "out.json"], says)


def refused_robot(capfd: pytest.CaptureFixture, folder: Path, name: str, says: str) -> None:
    """A robot is refused with recordings and without."""
    fails(capfd, folder, ["base-parameters", "--robot", name], says)
    fails(capfd, folder, ["identify", "good.csv", "--robot", name, "--out", "out.json"], says)


def assert_one_line(code: int, out: str, err: str, says: str) -> None:
    assert code == 2, err
    assert err.startswith("physident: error: "), err
    assert err.count("\n") == 1, err
    assert out == ""
    assert re.search(says, err), err
    assert len(err) < 1000, "the line does not fit a screen"


def contents(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() and path.stat().st_size < 1e8 else b""
        for path in folder.rglob("*")
        if not path.is_symlink()
    }


def command(arguments: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    """The command line in a process of its own, with bounded address space and one thread."""
    code = (
        f"import resource; resource.setrlimit(resource.RLIMIT_AS, ({MEMORY}, {MEMORY}));"
        " from physident.cli import main; main()"
    )
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    return subprocess.run(
        [sys.executable, "-c", code, *arguments],
        cwd=folder,
        env=os.environ | threads,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
