"""The recordings of a diagnosis, read again from their paths and accepted by their hashes; what both models predict."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from physident.errors import InputError
from physident.recording import Recording, load_recording
from physident.report.contents import Contents
from physident.view.pair import Pair, predict_pair


@dataclass(frozen=True, eq=False)
class Reread:
    """A recording that was used, whether it could be read again, and what was predicted of it; ``said`` is why not."""

    path: str
    sha256: str
    role: str
    recording: Recording | None
    pair: Pair | None
    said: str


def reread(contents: Contents) -> tuple[Reread, ...]:
    """Every recording of a diagnosis: looked for at its path, then at that path from the diagnosis file's folder."""
    return tuple(_reread(contents, used.path, used.sha256, used.role) for used in contents.recordings)


def _reread(c: Contents, path: str, sha256: str, role: str) -> Reread:
    def without(said: str, recording: Recording | None = None) -> Reread:
        return Reread(path, sha256, role, recording, None, said)

    places = [Path(path)] if c.path is None else [Path(path), c.path.parent / path]
    try:
        found = [place for place in places if place.is_file()]
        if not found:
            return without("not found")
        recordings = [load_recording(place, c.columns) for place in found]
    except (InputError, OSError, ValueError) as error:
        return without(f"cannot be read again: {error}")
    same = [recording for recording in recordings if recording.sha256 == sha256]
    if not same:
        return without("another recording lies there now: its hash differs")
    try:
        pair = predict_pair(c.model, c.extended, same[:1], c.filter, c.drive_gains)
    except InputError as error:
        return without(f"torque cannot be predicted: {error}", same[0])
    return Reread(path, sha256, role, same[0], pair, "read again, hash as diagnosed")
