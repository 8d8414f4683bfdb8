"""Execute the notebooks and keep their outputs: `python docs/notebooks/run.py [WORD]`.

Each runs in an empty folder, with this repository's package. With words after the command, only notebooks with such words in
their names are run.
"""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

import nbformat
from nbclient import NotebookClient

FOLDER = Path(__file__).resolve().parent
LIMIT = 600  # s for one cell
QUIET = {"OPENBLAS_NUM_THREADS": "1", "PYTHONWARNINGS": "ignore", "IPYTHONDIR": ""}  # no settings of the user's own


def executed(path: Path, folder: Path) -> nbformat.NotebookNode:
    """The notebook with the outputs of its cells, run in ``folder``; raises CellExecutionError for a cell that fails."""
    notebook = nbformat.read(path, as_version=4)
    own = {**os.environ, **QUIET, "IPYTHONDIR": str(folder / ".ipython"), "PYTHONPATH": os.pathsep.join(_packages())}
    client = NotebookClient(
        notebook,
        timeout=LIMIT,
        kernel_name="python3",
        record_timing=False,
        resources={"metadata": {"path": str(folder)}},
    )
    client.execute(env=own)
    for cell in notebook.cells:
        if cell.cell_type == "code":
            cell.outputs = [output for output in cell.outputs if output.get("name") != "stderr"]  # progress
    notebook.metadata.pop("language_info", None)  # the version of whoever ran it
    return notebook


def _packages() -> list[str]:
    return [str(FOLDER.parents[1]), *filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))]


def notebooks() -> list[Path]:
    """All notebooks of this folder."""
    return sorted(FOLDER.glob("*.ipynb"))


if __name__ == "__main__":
    for path in notebooks():
        if sys.argv[1:] and not any(word in path.name for word in sys.argv[1:]):
            continue
        with tempfile.TemporaryDirectory() as folder:
            nbformat.write(executed(path, Path(folder)), path)
        print(f"written: {path.name}")
