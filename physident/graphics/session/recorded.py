"""The recordings of a session as they were measured, so that the session's file is a recording too."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from physident.recordings.formats.rrd import ROOT
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
        values = {name: array.ravel() for name, array in channels.items() if array is not None}
        names = {} if recording.joint_names is None else {"joints": list(recording.joint_names)}
        rec.log(f"{ROOT}/{number}", rr.AnyValues(time=recording.time, **values, **names), static=True)
