"""Run the tutorials and the how-to pages that are played, and write their outputs into them: `python docs/tutorials/run.py`.

A page with the comment `<!-- played with: NAMES -->` starts with these recordings (recordings.py) in its folder. With words after the
command, only the pages with such words in their names are run.

Python blocks and lines that start with `physident` are run in order, in an empty folder; a Python block whose first line is the
name of a file, as a comment, is saved as that file. The text block after them gets their output.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import sys
import tempfile
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from physident.cli import run

FOLDER = Path(__file__).resolve().parent
BLOCK = re.compile(r"^```(python|sh|text)\n(.*?)^```\n", flags=re.S | re.M)
PLAYED = re.compile(r"^<!-- played(?: with: (.*?))? -->$", flags=re.M)
WAITING = re.compile(r"physident: .*, \d+ s")  # printed by slow machines only
FILE = re.compile(r"# (\w+\.py)\n")


def played(page: str, folder: Path) -> str:
    """The page with the outputs of its blocks, run in ``folder``; raises RuntimeError for a command that fails."""
    names: dict[str, Any] = {"__name__": "__main__"}
    printed = ""
    parts, at = [], 0
    with contextlib.chdir(folder), _importing_from(folder):
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


@contextlib.contextmanager
def _importing_from(folder: Path) -> Iterator[None]:
    """Modules that a page writes into its folder can be imported by it, as in a shell."""
    sys.path.insert(0, str(folder))
    before = set(sys.modules)
    try:
        yield
    finally:
        sys.path.remove(str(folder))
        for name in set(sys.modules) - before:
            if (file := getattr(sys.modules[name], "__file__", None)) and Path(file).parent == folder.resolve():
                del sys.modules[name]


def _python(code: str, names: dict[str, Any]) -> str:
    if file := FILE.match(code):
        Path(file[1]).write_text(code, encoding="utf-8")
        return ""
    with _printing() as out, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # where they are printed to depends on who runs the code
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
    """The lines without trailing spaces, and without those that say how long a slow machine has worked."""
    kept = [line.rstrip() for line in text.strip("\n").splitlines() if not WAITING.fullmatch(line)]
    return "".join(f"{line}\n" for line in kept)


def pages() -> dict[Path, tuple[str, ...]]:
    """Every page that is played, with the names of the recordings that it starts with."""
    found = {}
    for path in sorted([*FOLDER.glob("*.md"), *(FOLDER.parent / "how-to").glob("*.md")]):
        mark = PLAYED.search(path.read_text(encoding="utf-8"))
        if mark is not None or path.parent == FOLDER:
            found[path] = tuple(((mark and mark[1]) or "").split())
    return found


if __name__ == "__main__":
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    sys.path.insert(0, str(FOLDER))
    from recordings import put

    for path, names in pages().items():
        if sys.argv[1:] and not any(word in path.name for word in sys.argv[1:]):
            continue
        with tempfile.TemporaryDirectory() as folder:
            for name in names:
                put(name, Path(folder))
            path.write_text(played(path.read_text(encoding="utf-8"), Path(folder)), encoding="utf-8")
        print(f"written: {path.name}")
