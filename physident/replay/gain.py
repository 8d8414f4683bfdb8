"""The gain of a diagnosis in a simulator, as its record, its text and its report show it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from physident.diagnosis.result.diagnosis import Diagnosis
from physident.diagnosis.result.simulated import Simulated
from physident.estimation.estimate import as_estimate
from physident.recordings.recording import Recording
from physident.replay.replay import Simulator, replay


def with_simulator(
    found: Diagnosis, diagnosed: Sequence[Recording], holdout: Sequence[Recording], simulator: Simulator
) -> Diagnosis:
    """The diagnosis with the errors of both simulated arms, on the holdout, or on the diagnosed recordings without one.

    Raises InputError as ``replay`` does, as for a model whose links cannot exist in MuJoCo.
    """

    before = replace(as_estimate(found.model, found.filter), filter=found.filter, drive_gains=found.drive_gains)
    after = None if found.estimate is None else replace(found.estimate, filter=found.filter)
    result = replay(before, after, list(holdout or diagnosed), simulator).replay
    on = "recordings that were not diagnosed" if holdout else "the diagnosed recordings"
    extended = result.after
    simulated = Simulated(
        simulator=simulator,
        horizon=result.horizon,
        starts=result.starts,
        held_out=bool(holdout),
        tool_before=result.before.tool,
        tool_after=None if extended is None else extended.tool,
        before=tuple(result.before.position.tolist()),
        after=None if extended is None else tuple(extended.position.tolist()),
        sentence=f"{result.verdict}, on {on}",
    )
    return replace(found, simulated=simulated)
