"""What a check of the set-up states: the mistake, the joints, and the evidence for it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True, kw_only=True)
class SetupFinding:
    """A statement about how recordings and description fit together.

    ``kind`` is one word for the mistake, ``joints`` (from 1) where it is, empty for the whole arm; ``statement`` names
    the mistake and what to do, ``evidence`` gives the figures behind it. ``rivals`` are other
    mistakes, in words, that look the same in these recordings. ``void``: a model of these recordings would be wrong.
    ``note``: the statement says what the channel is, and nothing is wrong with it.
    """

    kind: str
    joints: tuple[int, ...]
    statement: str
    evidence: str
    void: bool
    rivals: tuple[str, ...] = ()
    note: bool = False

    def __str__(self) -> str:
        others = f"; or {'; or '.join(self.rivals)}" if self.rivals else ""
        return f"{self.statement}{others} ({self.evidence})"

    def as_dict(self) -> dict[str, Any]:
        """The finding as plain numbers and texts for JSON."""
        return asdict(self) | {"joints": list(self.joints), "rivals": list(self.rivals)}


def joint_list(joints: Iterable[int]) -> str:
    """Joints (from 1) in words: "joint 2", "joints 2 and 3", "joints 1, 2 and 3"."""
    names = [str(j) for j in sorted(joints)]
    if len(names) < 2:
        return f"joint {names[0]}" if names else "all joints"
    return f"joints {', '.join(names[:-1])} and {names[-1]}"


def within(joints: Iterable[int], n: int) -> str:
    """``joint_list``, or "all joints" where all ``n`` are meant."""
    chosen = tuple(joints)
    return "all joints" if len(set(chosen)) == n and n > 1 else joint_list(chosen)
