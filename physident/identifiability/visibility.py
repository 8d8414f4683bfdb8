"""Which parameters recordings can show: for each, the share of its column that the other columns cannot reproduce."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.regressor import Regressor
from physident.effects.effect import Column

Array = NDArray[np.float64]
VISIBLE = 1e-3  # share of energy below which noise a thirtieth of the column's size hides it
INVISIBLE = 1e-10


@dataclass(frozen=True, eq=False)
class Visibility:
    """``share`` (p,) of each column's energy outside the span of the rest, 0 (hidden) to 1 (alone); NaN where the
    column is zero: the recordings do not excite it at all."""

    columns: tuple[Column, ...]
    share: Array

    def as_dict(self) -> dict[str, Any]:
        """The shares by the parameters' names for JSON; None where the recordings do not excite a parameter at all."""
        named = zip(self.columns, self.share.tolist(), strict=True)
        return {"share": {column.name: None if np.isnan(share) else share for column, share in named}}

    def __repr__(self) -> str:
        joints = range(1, max(c.joint for c in self.columns) + 1)
        cells: dict[str, dict[int, float]] = {}
        for c, share in zip(self.columns, self.share, strict=True):
            label = "_".join(part for part in c.name.split("_") if not part.isdigit())
            cells.setdefault(label, {})[c.joint] = share
        width = max(map(len, ("effect", *cells))) + 1
        rows = [f"{'effect':<{width}}" + "".join(f"{j:>9d}" for j in joints)]
        for label, row in cells.items():
            rows.append(f"{label:<{width}}" + "".join(_cell(row[j]) if j in row else " " * 9 for j in joints).rstrip())
        hidden = sum(not s >= VISIBLE for s in self.share)
        rows.append(
            "share of each column's energy that the other columns cannot reproduce; . is none, o is no excitation"
        )
        return "\n".join(
            [*rows, f"verdict: {hidden} of {len(self.columns)} parameters cannot be distinguished from the others"]
        )


def measure_visibility(regressor: Regressor) -> Visibility:
    """The share of each column's energy outside the span of all other columns, every joint's torque scaled to one."""
    size = np.sqrt((regressor.torque**2).mean(axis=0))
    R, _, _ = regressor.compressed(1 / np.where(size > 0, size, 1.0))
    norm = np.linalg.norm(R, axis=0)
    share = np.full(len(norm), np.nan)
    excited = np.flatnonzero(norm > 1e-12 * norm.max())
    A = R[:, excited] / norm[excited]
    for k, i in enumerate(excited):
        rest = np.delete(A, k, axis=1)
        fitted = rest @ np.linalg.lstsq(rest, A[:, k], rcond=1e-11)[0]
        share[i] = float(np.sum((A[:, k] - fitted) ** 2))
    return Visibility(regressor.columns, np.where(share < INVISIBLE, 0.0, share))


def _cell(share: float) -> str:
    if np.isnan(share):
        return "        o"
    return "        ." if share < INVISIBLE else f"{share:9.2g}"
