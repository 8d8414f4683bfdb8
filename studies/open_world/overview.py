"""What a reader asks first: each world's main figures beside what was asked for, and every set that was run by itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from studies.open_world.summary import FIGURES

Figures = Mapping[str, Mapping[str, Any]]
ASKED = {
    "first": ">= 95",
    "others": "<= 10",
    "value": ">= 80",
    "interval": "95",
    "twin_false": "<= 2",
    "both": ">= 80",
    "third": "",
    "outside_wrong": "<= 15",
    "outside_joint": ">= 85",
}
BY = {"first": ("question", "tier"), "twin_false": ("question",)}
SHORT = {
    "first": "first",
    "others": "false beside",
    "twin_false": "twin accused",
    "both": "both of a pair",
    "outside_wrong": "outside misnamed",
}


def overview(worlds: Mapping[str, Mapping[str, Any]], names: Mapping[str, str]) -> str:
    """The main figures of some worlds [%] with their 95 % intervals, some of them by what was drawn."""
    chosen = [world for world in names if world in worlds]
    width = max(28, 2 + max(len(names[w]) for w in chosen))
    heads = "".join(f"{names[w]:<{width}}" for w in chosen).rstrip()
    lines = [f"{'[%], 95 % interval, trials':<62}{'asked':<8}{heads}"]
    for key, asked in ASKED.items():
        lines.append(_line(FIGURES[key][0], asked, [worlds[w]["figures"].get(key) for w in chosen], width))
        for stratum in BY.get(key, ()):
            for value in dict.fromkeys(value for w in chosen for value in worlds[w]["strata"][stratum]):
                cells = [worlds[w]["strata"][stratum].get(value, {}).get(key) for w in chosen]
                if any(cell and cell["n"] for cell in cells):
                    lines.append(_line(f"    {value}", "", cells, width))
    return "\n".join(lines)


def every_set(figures: Mapping[str, Mapping[str, Figures]], names: Mapping[str, str]) -> str:
    """The main figures of each set as hits of trials, by the rules of the day on which it was run."""
    lines = [f"{'set':<8}" + "".join(f"{head:>18}" for head in SHORT.values())]
    for world in names:
        lines.append(names[world])
        sets = sorted(figures.get(world, {}).items(), key=lambda item: int(item[0]))
        lines += [f"  {group:<6}" + "".join(f"{_hits(own[key]):>18}" for key in SHORT) for group, own in sets]
        lines.append("  all   " + "".join(f"{_hits(*(own[key] for _, own in sets)):>18}" for key in SHORT))
    return "\n".join(lines)


def _line(label: str, asked: str, cells: Sequence[Mapping[str, Any] | None], width: int) -> str:
    return (f"{label:<62}{asked:<8}" + "".join(f"{_cell(cell):<{width}}" for cell in cells)).rstrip()


def _cell(value: Mapping[str, Any] | None) -> str:
    if not value or not value["n"]:
        return "-"
    return f"{value['percent']:.0f} [{value['low']:.0f}, {value['high']:.0f}] of {value['n']}"


def _hits(*values: Mapping[str, Any]) -> str:
    hits, n = sum(round(v["percent"] * v["n"] / 100) for v in values), sum(v["n"] for v in values)
    return f"{hits} of {n}" if n else "-"
