"""Draws the README's pictures, docs/pictures/*.png, by running the script of each."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent


def main() -> None:
    """Run every docs/picture_*.py on one thread; the first that fails ends it."""
    for script in sorted(HERE.glob("picture_*.py")):
        print(f"{script.name}:", flush=True)
        subprocess.run([sys.executable, str(script)], env={**os.environ, "OPENBLAS_NUM_THREADS": "1"}, check=True)


if __name__ == "__main__":
    main()
