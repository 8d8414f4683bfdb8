"""A disk that becomes full: one line, the file that was there before, and nothing else."""

from __future__ import annotations

import resource
import subprocess
import sys
from pathlib import Path

import pytest

LIMIT = 20_000  # bytes that a file may have: less than any session


@pytest.mark.parametrize("before", [None, b"RRF2 an earlier session"], ids=["new", "replaced"])
def test_a_session_that_does_not_fit_leaves_what_was_there(before: bytes | None, folder: Path) -> None:
    (folder / "out").mkdir()
    target = folder / "out" / "session.rrd"
    if before is not None:
        target.write_bytes(before)
    command = [
        sys.executable,
        "-m",
        "physident",
        "view",
        "good.csv",
        "--model",
        "model.json",
        "--out",
        str(target),
        "--force",
    ]
    done = subprocess.run(
        command,
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (LIMIT, LIMIT)),
    )
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1].startswith("physident: error: output ")
    assert "Traceback" not in done.stderr
    assert [path.name for path in target.parent.iterdir()] == ([] if before is None else ["session.rrd"])
    assert before is None or target.read_bytes() == before
