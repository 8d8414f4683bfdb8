"""Run the tutorials in this folder and write their outputs into them: `python docs/tutorials/run.py`.

Python blocks and lines that start with `physident` are run in order, in an empty folder; a Python block whose first line is the
name of a file, as a comment, is saved as that file. The text block after them gets their output.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from physident.cli import run

FOLDER = Path(__file__).resolve().parent
BLOCK = re.compile(r"^```(python|sh|text)\n(.*?)^```\n", flags=re.S | re.M)
FILE = re.compile(r"# (\w+\.py)\n")


def played(page: str, folder: Path) -> str:
    """The page with the outputs of its blocks, run in ``folder``; raises RuntimeError for a command that fails."""
    names: dict[str, Any] = {"__name__": "__main__"}
    printed = ""
    parts, at = [], 0
    with contextlib.chdir(folder):
        for block in BLOCK.finditer(page):
            kind, text = block.groups()
            parts.append(page[at : block.start()])
            if kind == "text":
                parts.append(f"```text\n{printed}```\n")
            else:
                printed = _python(text, names) if kind == "python" else _shell(text)
                parts.append(block.group())
            at = block.end()
    return "".join([*parts, page[at:]])


def _python(code: str, names: dict[str, Any]) -> str:
    if file := FILE.match(code):
        Path(file[1]).write_text(code, encoding="utf-8")
        return ""
    with _printing() as out:
        exec(compile(code, "tutorial", "exec"), names)
    return _lines(out.getvalue())


def _shell(text: str) -> str:
    printed = ""
    for line in text.replace("\\\n", " ").splitlines():
        if not line.startswith("physident "):
            continue
        with _printing() as out:
            code = run(shlex.split(line, comments=True)[1:])
        if code:
            raise RuntimeError(f"{line}: exit code {code}: {out.getvalue()}")
        printed += out.getvalue()
    return _lines(printed)


@contextlib.contextmanager
def _printing() -> Iterator[io.StringIO]:
    """Collects standard output and standard error together, as a terminal shows them."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
        yield out


def _lines(text: str) -> str:
    """The lines without trailing spaces."""
    return "".join(f"{line.rstrip()}\n" for line in text.strip("\n").splitlines())


if __name__ == "__main__":
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    for path in sorted(FOLDER.glob("*.md")):
        with tempfile.TemporaryDirectory() as folder:
            path.write_text(played(path.read_text(encoding="utf-8"), Path(folder)), encoding="utf-8")
        print(f"written: {path.name}")
