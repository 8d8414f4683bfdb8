"""What a diagnosis gains in a simulator: how far the simulated arm is from the recorded one, before and after."""

from __future__ import annotations

from dataclasses import dataclass

from physident.json_records import NotNegative


@dataclass(frozen=True, kw_only=True)
class Simulated:
    """Errors (RMS) of the simulated arm, ``horizon`` [s] after each of ``starts`` measured states, under the measured torque.

    ``tool_before`` and ``tool_after`` [m] are those of the tool, ``before`` and ``after`` (n,) [rad|m] those of the joints;
    the ones after are None where nothing was found. ``held_out`` says that no recording of the replay was diagnosed, and
    ``sentence`` is the result in words.
    """

    simulator: str
    horizon: NotNegative
    starts: int
    held_out: bool
    tool_before: NotNegative
    tool_after: NotNegative | None
    before: tuple[NotNegative, ...]
    after: tuple[NotNegative, ...] | None
    sentence: str
