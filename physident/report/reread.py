"""Read the recordings of a diagnosis again from their paths, and accept those whose hash has not changed."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from physident.diagnosis.result.findings import UsedRecording
from physident.diagnosis.result.record import DiagnosisRecord
from physident.errors import InputError
from physident.recordings.formats.read import is_there
from physident.recordings.load import load_recording
from physident.recordings.recording import Recording


@dataclass(frozen=True, eq=False)
class Reread:
    """A recording that the diagnosis ``used``, read again; None where that failed. ``status`` describes the result."""

    used: UsedRecording
    recording: Recording | None
    status: str


def reread(contents: DiagnosisRecord) -> tuple[Reread, ...]:
    """All recordings of a diagnosis, searched at their path, then at that path from the diagnosis file's folder, then by their file's
    name in that folder and in the present one; only one with the hash of the diagnosis is taken."""
    return tuple(_reread(contents, used) for used in contents.recordings)


def _reread(c: DiagnosisRecord, used: UsedRecording) -> Reread:
    status = "not found"
    for place in _places(c, used.path):
        try:
            recording = load_recording(place, c.layout, joints=c.model.robot.joint_names)
        except (InputError, OSError, ValueError) as error:
            status = f"cannot be read again: {error}"
            continue
        if recording.sha256 == used.sha256:
            return Reread(used, recording, "read again, same hash")
        status = "changed: its hash is not that of the diagnosis"
    return Reread(used, None, status)


def _places(c: DiagnosisRecord, path: str) -> list[Path]:
    """The files and folders that a path may mean, each once."""
    name = Path(path).name
    folders = [] if c.path is None else [c.path.parent / path, c.path.parent / name]
    places = [Path(path), *folders, Path(name)]
    try:
        return list({place.resolve(): place for place in places if is_there(place)}.values())
    except (OSError, ValueError):  # a path that no file can have
        return []
