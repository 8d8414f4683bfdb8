"""The errors of a replay: how far the simulated arms of one or two models are from the real one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
NAMES = {"mujoco": "MuJoCo", "physident": "physident's own simulator"}


@dataclass(frozen=True, eq=False, kw_only=True)
class ReplayScore:
    """The errors (RMS) of one model's simulated arm of n joints.

    After the horizon, under the measured torque: ``position`` (n,) [rad|m], ``velocity`` (n,) [rad/s|m/s] and ``tool`` [m].
    Along the recorded motion, held by the controller: ``torque`` (n,) [N m|N] that it adds to the measured one, after the
    model's filter, ``following`` (n,) [rad|m] and ``tool_following`` [m] against the measured motion. ``lost`` is the share of the
    starts from which the arm is more than pi rad [m] away after the horizon, whose error counts as pi; all of the torque of a lost arm counts as error; ``lost_following`` is that share along the motion. ``stated`` lists what the simulator's
    file does not hold as the model does.
    """

    position: Array
    velocity: Array
    tool: float
    torque: Array
    following: Array
    tool_following: float
    lost: float
    lost_following: float
    stated: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """The score as plain numbers and texts for JSON, in SI units."""
        return {key: value.tolist() if isinstance(value, np.ndarray) else value for key, value in vars(self).items()}


@dataclass(frozen=True, eq=False, kw_only=True)
class Replay:
    """The errors of one or two models in a simulator, ``horizon`` [s] after each of ``starts`` measured states; ``units`` says in which
    units the joints that slide are shown."""

    joints: tuple[str, ...]
    units: str
    simulator: str
    horizon: float
    controller: str
    starts: int
    recordings: tuple[str, ...]
    before: ReplayScore
    after: ReplayScore | None

    @property
    def verdict(self) -> str:
        """One sentence: the tool's error after the horizon, before and after."""
        change = f"{1e3 * self.before.tool:.3g} mm"
        if self.after is not None:
            change += f" -> {1e3 * self.after.tool:.3g} mm"
        return f"in {NAMES[self.simulator]}, {self.horizon:g} s ahead: {change} at the tool"

    def as_dict(self) -> dict[str, Any]:
        """The replay as plain numbers and texts for JSON, in SI units."""
        return {
            "schema": "physident.replay/1",
            "joints": list(self.joints),
            "simulator": self.simulator,
            "horizon_s": self.horizon,
            "controller": self.controller,
            "starts": self.starts,
            "recordings": list(self.recordings),
            "before": self.before.as_dict(),
            "after": None if self.after is None else self.after.as_dict(),
            "verdict": self.verdict,
        }

    def __repr__(self) -> str:
        scores = [self.before] if self.after is None else [self.before, self.after]
        heads = ["model"] if self.after is None else ["before", "after"]
        width = 10 * len(scores)
        rows = [
            f"{self.starts} starts, {self.horizon:g} s ahead under the measured torque; then along the motion, held by {self.controller}",
            f"joint {'':<22}{'position [mrad]':>{width + 7}}{'velocity [mrad/s]':>{width + 8}}{'torque added [N m]':>{width + 9}}",
            f"{'':<28}" + 3 * (f"{'':7}" + "".join(f"{head:>10}" for head in heads) + " "),
        ]
        for j, name in enumerate(self.joints):
            cells = [(1e3, "position"), (1e3, "velocity"), (1.0, "torque")]
            texts = [f"{'':7}" + "".join(f"{k * getattr(s, key)[j]:10.3g}" for s in scores) + " " for k, key in cells]
            rows.append(f"{j + 1:5d} {name[:22]:<22}" + "".join(texts))
        rows += [self.units] if self.units else []
        tools = " -> ".join(f"{1e3 * score.tool_following:.3g}" for score in scores)
        rows.append(f"tool, held by the controller: {tools} mm from the measured motion")
        limit = "pi rad, or pi m" if self.units else "pi rad"
        for head, score in zip(heads, scores, strict=True):
            for share, when in ((score.lost, ""), (score.lost_following, " along the motion, though held")):
                if share:
                    rows.append(f"{head}: {100 * share:.1f} % of the simulated arms ran away{when} (more than {limit})")
            rows += [f"{head}: {text}" for text in score.stated]
        return "\n".join([*rows, f"verdict: {self.verdict}"])
