"""Outputs: what may be replaced, how, and that a set of results is written together."""

from __future__ import annotations

import os
import signal
import stat
import subprocess
import sys
import time
from pathlib import Path

import pytest

from physident import InputError
from physident.cli import run
from physident.files import read_text, write_text
from physident.outputs import check_target, together, write_with


@pytest.mark.parametrize("device", ["/dev/null", "/dev/full", "/dev/zero"])
def test_a_device_is_never_replaced(device: str) -> None:
    before = os.stat(device)
    for refuse in (check_target, lambda path: write_text(path, "text")):
        with pytest.raises(InputError, match="is a device"):
            refuse(device)
    after = os.stat(device)
    assert (before.st_mode, before.st_rdev, before.st_ino) == (after.st_mode, after.st_rdev, after.st_ino)


def test_a_pipe_is_refused_as_input_and_as_output(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with pytest.raises(InputError, match="a pipe"):
        write_text(pipe, "text")
    with pytest.raises(InputError, match="a pipe"):  # without the check this waits for ever
        read_text(pipe, 100, "a model")
    assert stat.S_ISFIFO(pipe.stat().st_mode)


@pytest.mark.parametrize("option", ["--model", "--diagnosis", "--trajectory"])
def test_verbs_do_not_wait_for_a_pipe(option: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    pipe, out = str(tmp_path / "pipe"), tmp_path / "out"
    os.mkfifo(pipe)
    (tmp_path / "r.csv").write_text("time,q_1\n0,0\n")
    verb = {
        "--model": ["validate", str(tmp_path / "r.csv")],
        "--diagnosis": ["report", "--out", f"{out}.html"],
        "--trajectory": ["simulate", "--robot", "ur5", "--out", f"{out}.csv"],
    }[option]
    assert run([*verb, option, pipe]) == 2
    assert "is a device, a pipe or a socket" in capfd.readouterr().err


def test_the_target_of_a_link_is_written_and_its_mode_kept(tmp_path: Path) -> None:
    target, link = tmp_path / "real" / "model.json", tmp_path / "model.json"
    target.parent.mkdir()
    target.write_text("old")
    target.chmod(0o600)
    link.symlink_to(target)
    write_text(link, "new")
    assert link.is_symlink()
    assert target.read_text() == "new"
    assert stat.S_IMODE(target.stat().st_mode) == 0o600
    dangling = tmp_path / "later.json"
    dangling.symlink_to(tmp_path / "real" / "later.json")
    write_text(dangling, "new")
    assert dangling.is_symlink()
    assert (tmp_path / "real" / "later.json").read_text() == "new"


def test_a_link_to_itself_or_to_a_device_is_refused(tmp_path: Path) -> None:
    loop, null = tmp_path / "loop", tmp_path / "null"
    loop.symlink_to(loop)
    null.symlink_to("/dev/null")
    for link in (loop, null):
        with pytest.raises(InputError, match="output"):
            write_text(link, "text")
        assert link.is_symlink()


def test_a_read_only_file_is_not_replaced(tmp_path: Path) -> None:
    """For root too, to whom every file is writable."""
    target = tmp_path / "kept.json"
    target.write_text("kept")
    target.chmod(0o444)
    with pytest.raises(InputError, match="read-only"):
        write_text(target, "new")
    assert target.read_text() == "kept"


@pytest.mark.parametrize("stop", [KeyboardInterrupt(), InputError("no"), None])
def test_a_set_is_written_together_or_not_at_all(stop: BaseException | None, tmp_path: Path) -> None:
    first, second = tmp_path / "a.json", tmp_path / "b.json"
    for path in (first, second):
        path.write_text("old")

    def write_both() -> None:
        with together():
            write_text(first, "new")
            assert first.read_text() == "old"
            if stop is not None:
                raise stop
            write_text(second, "new")

    if stop is None:
        write_both()
    else:
        with pytest.raises((KeyboardInterrupt, InputError)):
            write_both()
    expected = "new" if stop is None else "old"
    assert [path.read_text() for path in (first, second)] == [expected, expected]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.json", "b.json"]


@pytest.mark.parametrize("name", ["-", "/dev/stdout"])
def test_a_dash_is_standard_output_where_the_result_stands_alone(name: str, capfd: pytest.CaptureFixture[str]) -> None:
    import json

    assert run(["base-parameters", "--robot", "ur5", "--json", name]) == 0
    out, err = capfd.readouterr()
    assert json.loads(out)["parameters"] == 60
    assert err.startswith("36 base parameters of 60")
    assert not Path("-").exists()


def test_termination_leaves_no_temporary_file(tmp_path: Path) -> None:
    """A real signal in a real process, while a result is being written."""
    code = f"""
import time
from pathlib import Path
import physident.cli as cli
import physident.dynamics.model
from physident.files import VERSION
import physident.files
def slow(path, data):
    from physident.outputs import write_with
    write_with(path, lambda t: (t.write_text("half"), Path({str(tmp_path / "started")!r}).write_text(""), time.sleep(60)))
physident.files.write_json = slow
import sys
sys.argv = ["physident", "base-parameters", "--robot", "ur5", "--json", {str(tmp_path / "out.json")!r}]
cli.main()
"""
    process = subprocess.Popen([sys.executable, "-c", code])
    end = time.monotonic() + 60
    while not (tmp_path / "started").exists() and time.monotonic() < end:
        time.sleep(0.05)
    process.send_signal(signal.SIGTERM)
    assert process.wait(30) == 128 + signal.SIGTERM
    assert [path.name for path in tmp_path.iterdir()] == ["started"]


@pytest.mark.parametrize("stream", ["1", "2"])
def test_a_closed_stream_is_no_crash(stream: str, tmp_path: Path) -> None:
    command = f"{sys.executable} -m physident base-parameters --robot ur5 --json {tmp_path / 'out.json'} {stream}>&-"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert (tmp_path / "out.json").read_text().startswith("{")


def test_standard_output_on_a_full_disk_is_an_error() -> None:
    command = f"{sys.executable} -m physident base-parameters --robot ur5 >/dev/full"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert (
        done.stderr == "physident: error: standard output: No space left on device; expected a place that can be used\n"
    )


@pytest.mark.parametrize("content", ["", "time,q_1\n0,1\n", "notes\n", '{"mine": 1}'])
def test_a_file_of_another_program_is_kept_unless_forced(
    content: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out.json"
    out.write_text(content)
    command = ["base-parameters", "--robot", "ur5", "--json", str(out)]
    if content:
        assert run(command) == 2
        assert "physident did not write it; choose another path, or add --force" in capfd.readouterr().err
        assert out.read_text() == content
    assert run([*command, "--force"] if content else command) == 0
    assert run(command) == 0  # now it is the program's own


def test_figures_pages_and_sessions_of_the_program_are_known(tmp_path: Path) -> None:
    import rerun as rr

    from physident.cli.replacement import check_replacement
    from physident.graphics.style import FORMATS, figure, save

    for ending in FORMATS:
        fig, _ = figure(1)
        save(fig, tmp_path / f"figure{ending}")
        check_replacement(tmp_path / f"figure{ending}")
    for name in ("physident", "another"):
        recording = rr.RecordingStream(name, send_properties=False)
        recording.save(tmp_path / f"{name}.rrd")
        recording.disconnect()
    check_replacement(tmp_path / "physident.rrd")
    with pytest.raises(InputError, match="did not write it"):
        check_replacement(tmp_path / "another.rrd")
    import matplotlib.figure

    matplotlib.figure.Figure().savefig(tmp_path / "mine.png")
    with pytest.raises(InputError, match="did not write it"):
        check_replacement(tmp_path / "mine.png")


def test_a_writer_s_own_failure_leaves_nothing(tmp_path: Path) -> None:
    def full(temporary: Path) -> None:
        temporary.write_text("half")
        raise OSError(28, "No space left on device")

    with pytest.raises(InputError, match="No space left"):
        write_with(tmp_path / "out.rrd", full)
    assert list(tmp_path.iterdir()) == []
