"""Writes the tables of README from the studies' kept results, so that no number is typed by hand."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]


def results(study: str) -> dict[str, Any]:
    """What a study kept."""
    return json.loads((ROOT / "studies" / study / "results.json").read_text(encoding="utf-8"))


def real_arms() -> str:
    """Errors of the default model on real recordings that were not fitted."""
    ur10e, ur5 = results("ur10e_baseline"), results("ur5_baseline")
    rows = ["| arm, judged on | " + " | ".join(f"J{j}" for j in range(1, 7)) + " |", "|---|" + "---|" * 6]
    cases = {
        f"UR10e, each of eight runs left out once, {ur10e['cutoff']:g} Hz": ur10e["wls"]["mean"],
        f"UR5, move8 after fitting three others, {ur5['cutoff']:g} Hz": ur5["relative_percent"]["move8"],
    }
    rows += [f"| {name} | " + " | ".join(f"{v:.1f}" for v in values) + " |" for name, values in cases.items()]
    return "\n".join(rows)


BLOCKS = {"real arms": real_arms}


def filled(text: str) -> str:
    """README's text with every marked block made anew."""
    for name, make in BLOCKS.items():
        block = f"<!-- {name} -->\n{make()}\n<!-- /{name} -->"
        text, count = re.subn(rf"<!-- {name} -->.*?<!-- /{name} -->", lambda _, block=block: block, text, flags=re.S)
        if count != 1:
            raise SystemExit(f"README.md: {count} blocks named {name!r}, expected one")
    return text


if __name__ == "__main__":
    readme = ROOT / "README.md"
    readme.write_text(filled(readme.read_text(encoding="utf-8")), encoding="utf-8")
