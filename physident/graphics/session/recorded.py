"""The recordings of a session as they were measured, so that the session's file is a recording too."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from physident.recordings.formats.rrd import CLOCK, JOINTS, ROOT
from physident.recordings.recording import Recording

if TYPE_CHECKING:
    import rerun as rr


def log_recordings(rec: rr.RecordingStream, recordings: Sequence[Recording]) -> None:
    """Log each recording's good rows as they are; no view shows them."""
    import rerun as rr

    for number, recording in enumerate(recordings):
        effort = recording.effort_kind.replace("torque", "tau") if recording.effort_stated else "effort"
        channels = {
            "q": recording.q,
            "dq": recording.dq,
            effort: recording.effort,
            "temperature": recording.temperature,
        }
        values: dict[str, Any] = {name: array.ravel() for name, array in channels.items() if array is not None}
        if recording.joint_names is not None:
            values[JOINTS] = list(recording.joint_names)
        rec.log(f"{ROOT}/{number}", rr.AnyValues(**{CLOCK: recording.time}, **values), static=True)
