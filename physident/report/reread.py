"""The recordings of a diagnosis, read again from their paths and accepted by their hashes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from physident.diagnosis.result.findings import UsedRecording
from physident.diagnosis.result.record import DiagnosisRecord
from physident.errors import InputError
from physident.recordings.load import load_recording
from physident.recordings.recording import Recording


@dataclass(frozen=True, eq=False)
class Reread:
    """A recording that was used; ``recording`` is None where it could not be had again, and ``said`` tells why."""

    used: UsedRecording
    recording: Recording | None
    said: str


def reread(contents: DiagnosisRecord) -> tuple[Reread, ...]:
    """Every recording of a diagnosis: looked for at its path, then at that path from the diagnosis file's folder."""
    return tuple(_reread(contents, used) for used in contents.recordings)


def _reread(c: DiagnosisRecord, used: UsedRecording) -> Reread:
    said = "not found"
    for place in _places(c, used.path):
        try:
            recording = load_recording(place, c.columns)
        except (InputError, OSError, ValueError) as error:
            said = f"cannot be read again: {error}"
            continue
        if recording.sha256 == used.sha256:
            return Reread(used, recording, "read again, hash as diagnosed")
        said = "another recording lies there now: its hash differs"
    return Reread(used, None, said)


def _places(c: DiagnosisRecord, path: str) -> list[Path]:
    """Where a file of that path lies: plain files only, each once."""
    places = [Path(path)] if c.path is None else [Path(path), c.path.parent / path]
    try:
        return list({place.resolve(): place for place in places if place.is_file()}.values())
    except (OSError, ValueError):  # a path that no file can have
        return []
