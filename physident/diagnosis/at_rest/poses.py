"""The comparison of recordings at standstill with a model, pose by pose."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.result.text import wrapped
from physident.files import write_json

Array = NDArray[np.float64]
SCHEMA = "physident.at_rest/1"
DOUBT = 2.0  # standard errors
COLUMN = 40  # characters of a row's label
NOTHING_MORE = (
    "At standstill, static friction takes any value up to the breakaway torque. These recordings contain no information"
    " about friction, rotors or inertia, and about gravity only where the difference exceeds that range: record slow"
    " motions in both directions."
)


@dataclass(frozen=True, eq=False)
class Pose:
    """One recording at rest: mean position ``q`` (n,) [rad|m]; ``measured`` torque (n,) [N m|N] and its mean's model,
    ``gravity`` (n,) with offsets, known to ``std`` (n,); ``friction`` (n,) that the model needs to move each joint."""

    source: str
    duration: float
    q: Array
    measured: Array
    gravity: Array
    std: Array
    friction: Array

    @property
    def held(self) -> Array:
        """What friction holds (n,) [N m|N], or what the model gets wrong: at rest the same."""
        return self.measured - self.gravity

    @property
    def outside(self) -> tuple[int, ...]:
        """The joints (from 1) whose torque friction cannot explain."""
        beyond = np.abs(self.held) > self.friction + DOUBT * self.std
        return tuple(int(j) + 1 for j in np.flatnonzero(beyond))

    def as_dict(self) -> dict[str, Any]:
        """The pose as JSON can hold it."""
        plain = {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in vars(self).items()}
        return {**plain, "held": self.held.tolist(), "outside": list(self.outside)}


@dataclass(frozen=True, eq=False)
class AtRest:
    """The comparison of recordings at standstill with a model, pose by pose."""

    poses: tuple[Pose, ...]
    joints: tuple[str, ...]
    torque_units: tuple[str, ...]

    @property
    def outside(self) -> tuple[int, ...]:
        """The joints (from 1) whose torque leaves friction's band in some pose."""
        return tuple(sorted({j for pose in self.poses for j in pose.outside}))

    def as_dict(self) -> dict[str, Any]:
        """The answer as JSON can hold it (schema physident.at_rest/1)."""
        return {"schema": SCHEMA, "poses": [pose.as_dict() for pose in self.poses], "outside": list(self.outside)}

    def save(self, path: str | Path) -> None:
        """Write the answer as JSON, whole or not at all."""
        write_json(path, self.as_dict())

    def __repr__(self) -> str:
        rows = [f"at standstill: {self._answer()}", f"  {NOTHING_MORE}"]
        for pose in self.poses:
            title = f"{Path(pose.source).name}, {pose.duration:.1f} s at rest"
            rows += ["", title.ljust(COLUMN) + "".join(f"{j:>9d}" for j in range(1, len(self.joints) + 1))]
            unit = "|".join(dict.fromkeys(self.torque_units))
            table = {
                f"  measured [{unit}]": pose.measured, f"  gravity, by the model [{unit}]": pose.gravity,
                f"  difference [{unit}]": pose.held, f"  breakaway torque [{unit}]": pose.friction,
            }  # fmt: skip
            rows += [label.ljust(COLUMN) + "".join(f" {x:8.3g}" for x in values) for label, values in table.items()]
        return "\n".join(part for row in rows for part in wrapped(row))

    def _answer(self) -> str:
        count = len(self.poses) * len(self.joints)
        sizes = np.max([np.abs(pose.held) for pose in self.poses], axis=0)
        units = dict.fromkeys(self.torque_units)
        most = " and ".join(f"{sizes[[one == unit for one in self.torque_units]].max():.2g} {unit}" for unit in units)
        if not self.outside:
            return (
                f"nothing contradicts the model; the {count} torques differ from modelled gravity by up to {most},"
                " never by more than static friction can explain"
            )
        several = "s" if len(self.outside) > 1 else ""
        names = ", ".join(map(str, self.outside))
        return (
            f"joint{several} {names}: static friction cannot explain the difference between measured and modelled gravity"
            " torque"
        )
