"""Bags with flipped bytes: either one line, or a recording whose damaged messages are counted and named."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from tests.bags import write_bag

ROWS = 300


@pytest.fixture(scope="module")
def recording() -> pid.Recording:
    time, rates = 0.02 * np.arange(ROWS), np.linspace(0.5, 1.5, 6)
    angle = time[:, None] * rates
    return pid.Recording.from_arrays(time, np.sin(angle), 5 * np.cos(angle), rates * np.cos(angle))


@pytest.mark.parametrize("storage", ["mcap", "sqlite"])
@pytest.mark.parametrize("flips", [1, 5])
def test_a_bag_with_flipped_bytes(storage: str, flips: int, recording: pid.Recording, tmp_path: Path) -> None:
    """Nothing but InputError, in one line; what is read has every row that is not named as left out."""
    ending = "mcap" if storage == "mcap" else "db3"
    whole = next(write_bag(tmp_path / "bag", recording, storage=storage).glob(f"*.{ending}")).read_bytes()
    path, rng = tmp_path / f"damaged.{ending}", np.random.default_rng(flips)
    readable, named, lines = 0, 0, []
    for _ in range(60):
        data = np.frombuffer(whole, dtype=np.uint8).copy()
        data[rng.integers(len(data), size=flips)] ^= rng.integers(1, 256, size=flips).astype(np.uint8)
        path.write_bytes(data.tobytes())
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            try:
                found = pid.load_recording(path)
            except pid.InputError as error:
                lines.append(str(error))
                continue
        missing = ROWS - len(found.time) - len(found.rejected)
        assert missing == 0 or any(f"{missing} of {ROWS} messages are missing" in str(one.message) for one in told)
        readable, named = readable + 1, named + len(found.rejected)
    assert readable + len(lines) == 60
    assert all(len(line.splitlines()) == 1 for line in lines)
    assert readable >= 10
    assert named >= 5


def test_a_message_of_damaged_bytes_or_names_is_left_out_by_number(recording: pid.Recording, tmp_path: Path) -> None:
    whole = next(write_bag(tmp_path / "bag", recording, storage="sqlite").glob("*.db3")).read_bytes()
    first, second = (_nth(whole, b"elbow_joint", k) for k in (40, 90))
    data = bytearray(whole)
    data[first : first + 5] = b"elbox"
    data[second - 4] = 255  # the length of the name
    path = tmp_path / "damaged.db3"
    path.write_bytes(bytes(data))
    found = pid.load_recording(path)
    assert len(found.time) == ROWS - 2
    named, unread = sorted((row.reason for row in found.rejected), key=len)
    if unread.startswith("names"):
        named, unread = unread, named
    assert named == "names joints as no other message does (elbox_joint)"
    assert unread.startswith("no message of joint states (")
    stamps = {round(50 * t) + 1 for t in found.time}
    assert stamps.isdisjoint(row.row for row in found.rejected)


def _nth(data: bytes, wanted: bytes, count: int) -> int:
    at = -1
    for _ in range(count + 1):
        at = data.index(wanted, at + 1)
    return at
