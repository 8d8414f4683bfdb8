"""The viewer is reached from this machine alone, and the page it serves reaches nothing else."""

from __future__ import annotations

import socket
import subprocess
import urllib.request
from pathlib import Path

import pytest

import physident as pid
from physident.cli import run
from physident.graphics.viewer import HOST, SESSION, _quiet, web_server


def test_statistics_stay_off(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FORCE_RERUN_ANALYTICS", "1")
    monkeypatch.delenv("CI", raising=False)
    assert _quiet()["CI"] == "true"
    assert "FORCE_RERUN_ANALYTICS" not in _quiet()


def test_the_page_may_talk_to_its_server_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[list[str]] = []
    popen = subprocess.Popen
    monkeypatch.setattr(
        subprocess, "Popen", lambda command, **options: started.append(command) or popen(command, **options)
    )
    path = tmp_path / "session.rrd"
    path.write_bytes(bytes(range(256)) * 100)
    with web_server(path) as address:
        page, session = address.split("?url=")
        assert page.startswith(f"http://{HOST}:")
        with urllib.request.urlopen(page) as answer:
            policy = answer.headers["Content-Security-Policy"]
            assert b"re_viewer.js" in answer.read()
        rules = dict(rule.strip().split(" ", 1) for rule in policy.split(";"))
        for rule in ("default-src", "connect-src"):
            sources = set(rules[rule].split())
            assert not {s for s in sources if "://" in s or s in ("*", "http:", "https:", "ws:", "wss:")}
        assert session.endswith(SESSION)
        with urllib.request.urlopen(session) as answer:
            assert answer.read() == path.read_bytes()
        port = int(page.rsplit(":", 1)[1].strip("/"))
        others = {a[4][0] for a in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)} - {HOST}
        for other in others:
            with socket.socket() as probe:
                probe.settimeout(1.0)
                assert probe.connect_ex((other, port)) != 0
    with pytest.raises(OSError):
        urllib.request.urlopen(page, timeout=1)
    for option in ("--port", "--web-viewer-port"):  # the viewer's own server has ended too
        with socket.socket() as probe:
            assert probe.connect_ex((HOST, int(started[0][started[0].index(option) + 1]))) != 0


def test_the_package_and_the_function_share_a_name(tmp_path: Path, ur5: pid.Robot) -> None:
    import physident.graphics.style

    plan = pid.random_trajectory(ur5, seed=1)
    pid.view(robot=ur5, plan=plan, to=tmp_path / "plan.rrd")
    assert (tmp_path / "plan.rrd").stat().st_size > 1000
    assert physident.graphics.style.effect_colour("contact").startswith("#")


def test_what_cannot_be_shown_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str], ur5: pid.Robot) -> None:
    plan, broken = tmp_path / "plan.json", tmp_path / "broken.json"
    pid.random_trajectory(ur5, seed=1).save(plan)
    broken.write_text('{"schema": "physident.design/1", "trajectory": {}}')
    out = str(tmp_path / "s.rrd")
    for arguments, said in (
        (["--out", out], "nothing to show"),
        (["--plan", str(plan), "--out", out], "no robot is given"),
        (["--plan", str(plan), "--robot", "ur5", "--out", str(tmp_path / "s.html")], "expected .rrd"),
        (["--plan", str(plan), "--robot", "ur5", "--meshes", str(plan), "--out", out], "is no folder"),
        (["--plan", str(broken), "--robot", "ur5", "--out", out], "broken.json"),
        (["--plan", str(plan), "--robot", "ur5", "--out", str(tmp_path / "no" / "s.rrd")], "does not exist"),
        ([str(tmp_path / "absent.csv"), "--robot", "ur5", "--out", out], "not found"),
    ):
        assert run(["view", *arguments]) == 2
        error = capsys.readouterr().err
        assert said in error
        assert error.count("\n") == 1
    assert sorted(p.name for p in tmp_path.iterdir()) == ["broken.json", "plan.json"]
    assert run(["view", "--plan", str(plan), "--robot", "ur5", "--out", out]) == 0
    assert "written" in capsys.readouterr().out
