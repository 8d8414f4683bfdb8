"""Files are written whole or not at all."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from physident import InputError
from physident.files import read_text, write_text
from physident.outputs import check_target, write_with


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    target = tmp_path / "out.json"
    write_text(target, "old")

    def half(temporary: Path) -> None:
        assert temporary.suffix == ".json"
        temporary.write_text("half")
        raise RuntimeError("power cut")

    with pytest.raises(RuntimeError):
        write_with(target, half)
    assert [path.name for path in tmp_path.iterdir()] == ["out.json"]
    assert target.read_text() == "old"


def test_the_old_file_stays_until_the_new_one_is_whole(tmp_path: Path) -> None:
    target = tmp_path / "out.txt"
    write_text(target, "old")

    def write(temporary: Path) -> None:
        temporary.write_text("new")
        assert target.read_text() == "old"

    write_with(target, write)
    assert target.read_text() == "new"
    mask = os.umask(0)
    os.umask(mask)
    assert target.stat().st_mode & 0o777 == 0o666 & ~mask


@pytest.mark.parametrize("name", ["", "nowhere/out", "x" * 300, "file/out"])
def test_a_place_that_takes_no_file(tmp_path: Path, name: str) -> None:
    (tmp_path / "file").write_text("")
    before = sorted(tmp_path.iterdir())
    for refuse in (check_target, lambda path: write_text(path, "text")):
        with pytest.raises(InputError, match="output"):
            refuse(tmp_path / name)
    assert sorted(tmp_path.iterdir()) == before


def test_read_text_is_bounded_and_says_what_it_wanted(tmp_path: Path) -> None:
    path = tmp_path / "model"
    path.write_bytes(b"\xef\xbb\xbf" + "µ".encode())
    assert read_text(path, 10, "a model") == "µ"
    with pytest.raises(InputError, match="5 bytes, expected a model of at most 4"):
        read_text(path, 4, "a model")
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match="not UTF-8 text"):
        read_text(path, 10, "a model")
    with pytest.raises(InputError, match="No such file"):
        read_text(tmp_path / "none", 10, "a model")
