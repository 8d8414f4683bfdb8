"""Wrong set-ups and effort channels on real and simulated arms: how often the right mistake and joint are named.

``python -m studies.setup_checks.run`` from the project's root, with PHYSIDENT_DATA; the package example-robot-data describes
two of the five real arms. Recordings of simulated arms are kept in ``~/.cache/physident/setup_checks``.
"""

from __future__ import annotations

import os
import zlib
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from physident.errors import InputError
from physident.setup_checks import SetupFinding, check_setup
from studies.kept import keep
from studies.setup_checks.arms import Arm, real_arms, simulated_arm
from studies.setup_checks.channels import CHANNELS
from studies.setup_checks.mistakes import MISTAKES, Wrong

HERE = Path(__file__).parent
CACHE = Path(os.environ.get("PHYSIDENT_CACHE", Path.home() / ".cache" / "physident")) / "setup_checks"
FIRST, ARMS = 88_000, 50  # seeds of the simulated arms; README.md says what changed after a first look at them
JOINED = {"ur10e": "ur10e 20_02", "ur5": "ur5 move"}  # real arms with several recordings of one set-up
REFUSED = {"position_degrees": "degrees", "position_motor": "motor"}  # what the refusal of a file says
Make = Callable[[Arm, np.random.Generator], Wrong | None]


def main() -> None:
    """Run everything, and keep the results."""
    CACHE.mkdir(parents=True, exist_ok=True)
    alone = list(real_arms())
    joined = _joined(alone)
    simulated = [simulated_arm(seed, CACHE) for seed in range(FIRST, FIRST + ARMS)]
    days = [
        replace(arm, recordings=(r,), plans=(p,))
        for arm in simulated
        for r, p in zip(arm.recordings, arm.plans, strict=True)
    ]
    groups = {"five real arms": joined, "real recordings alone": alone, "simulated arms": simulated}
    results: dict[str, Any] = {"mistakes": {}, "channels": {}, "healthy": {}}
    for name, arms in groups.items():
        results["mistakes"][name] = _confusion(MISTAKES, arms)
    results["channels"]["simulated arms"] = _confusion(CHANNELS, simulated)
    for name, arms in (groups | {"simulated recordings alone": days}).items():
        found = {arm.name: [f.kind for f in check_setup(arm.robot, arm.recordings)] for arm in arms}
        wrong = {arm: kinds for arm, kinds in found.items() if set(kinds) - {"link_side"}}
        results["healthy"][name] = {"checked": len(arms), "accused": wrong}
    results["real channels"] = {arm.name: [str(f) for f in check_setup(arm.robot, arm.recordings)] for arm in alone}
    keep(HERE, results, _table(results))


def _joined(alone: Iterable[Arm]) -> list[Arm]:
    """The five real arms, each with all of its recordings without a load or a contact."""
    arms = list(alone)
    result = [arm for arm in arms if " " not in arm.name]
    for name, prefix in JOINED.items():
        own = [arm for arm in arms if arm.name.startswith(prefix) and "contact" not in arm.name]
        if own:
            result.append(Arm(name, own[0].robot, tuple(r for arm in own for r in arm.recordings)))
    return result


def _confusion(makers: Sequence[Make], arms: Sequence[Arm]) -> dict[str, Any]:
    """For each mistake: how often it was named, and what was named instead."""
    result = {}
    for make in makers:
        named: Counter[str] = Counter()
        for arm in arms:
            seed = [zlib.crc32(text.encode()) for text in (arm.name, make.__name__)]
            wrong = make(arm, np.random.default_rng(seed))
            if wrong is not None:
                named[_judged(wrong)] += 1
        result[make.__name__] = dict(named.most_common())
    return result


def _judged(wrong: Wrong) -> str:
    """ "right", "right, with rivals" where it is named first among others, "a rival", or the kind that was named instead."""
    try:
        found = check_setup(wrong.robot, wrong.make())
    except InputError as error:
        said = [word for kind, word in REFUSED.items() if kind in wrong.kinds and word in str(error)]
        return "right (the file is refused)" if said else "refused for another reason"
    first: SetupFinding | None = found[0] if found else None
    if first is None:
        return "nothing"
    if first.kind in wrong.kinds and (not wrong.joints or first.joints == wrong.joints):
        return "right, with rivals" if first.rivals else "right"
    name = f"{first.kind} on other joints" if first.kind in wrong.kinds else first.kind
    return f"{name}, with rivals" if first.rivals else name


def _table(results: dict[str, Any]) -> str:
    rows = []
    for part in ("mistakes", "channels"):
        for group, confusion in results[part].items():
            total = sum(sum(named.values()) for named in confusion.values())
            right = sum(_right(named) for named in confusion.values())
            rows.append(f"{part}, {group}: {right} of {total} named right, {100 * right / total:.1f} %")
            for name, named in confusion.items():
                others = ", ".join(f"{count} {kind}" for kind, count in named.items() if kind != "right")
                rows.append(
                    f"  {name:<22}{_right(named):4d} of {sum(named.values()):3d}" + (f"   {others}" if others else "")
                )
            rows.append("")
    for group, healthy in results["healthy"].items():
        accused = "; ".join(f"{arm}: {', '.join(kinds)}" for arm, kinds in healthy["accused"].items())
        rows.append(
            f"healthy, {group}: {len(healthy['accused'])} of {healthy['checked']} accused"
            + (f" ({accused})" if accused else "")
        )
    rows.append("")
    rows.append("what the efforts of real recordings are said to be, other than of geared motors:")
    rows += [f"  {arm}: {text}" for arm, texts in results["real channels"].items() for text in texts]
    return "\n".join(rows)


def _right(named: dict[str, int]) -> int:
    return sum(count for kind, count in named.items() if kind.startswith("right"))


if __name__ == "__main__":
    main()
