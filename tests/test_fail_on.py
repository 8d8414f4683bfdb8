"""A job that checks an arm ends with exit code 4 for a fault, with 2 for a recording that no answer can be drawn from, else with 0."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.cli import run
from tests.test_cli import _csv
from tests.test_identify import _recording


@pytest.fixture(scope="module")
def model(ur5: pid.Robot, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fail_on")
    runs = [str(_csv(_recording(ur5, seed, 0.2), folder / f"{seed}.csv")) for seed in (1, 2)]
    assert run(["identify", *runs, "--robot", "ur5", "--out", str(folder / "model.json")]) == 0
    return folder / "model.json"


def _ends(model: Path, recording: pid.Recording, fail_on: str) -> int:
    path = _csv(recording, model.parent / "today.csv")
    return run(["diagnose", "--model", str(model), str(path), "--fail-on", fail_on])


def test_what_nothing_explains_fails_where_that_is_asked(ur5: pid.Robot, model: Path) -> None:
    """A torque that wanders by itself is no function of anything that is measured."""
    healthy = _recording(ur5, 3, 0.2)
    wander, rng = np.zeros(len(healthy.time)), np.random.default_rng(5)
    step = float(np.median(np.diff(healthy.time)))
    for k in range(1, len(wander)):
        wander[k] = wander[k - 1] * (1 - step / 0.3) + rng.normal(0.0, np.sqrt(2 * step / 0.3))
    effort = np.array(healthy.effort)
    effort[:, 2] += 6.0 * wander
    assert _ends(model, replace(healthy, effort=effort), "cause") == 0
    assert _ends(model, replace(healthy, effort=effort), "unexplained") == 4


def test_no_answer_is_drawn_from_a_wrong_set_up(
    ur5: pid.Robot, model: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    healthy = _recording(ur5, 3, 0.2)
    assert healthy.dq is not None
    stands = np.arange(6) == 2
    frozen = replace(healthy, q=np.where(stands, 0.3, healthy.q), dq=np.where(stands, 0.0, healthy.dq))
    at_rest = replace(healthy, q=0 * healthy.q + healthy.q[0], dq=0 * healthy.dq)
    for recording, says in ((frozen, "its encoder is frozen"), (at_rest, "no recording moves")):
        for fail_on in ("cause", "unexplained"):
            capsys.readouterr()
            assert _ends(model, recording, fail_on) == 2
            out = capsys.readouterr()
            assert says in out.err
            assert out.out == ""
    assert _ends(model, healthy, "everything") == 2


def test_a_change_is_no_answer_where_nobody_knows_what_was_before(
    ur5: pid.Robot, model: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The model without the recordings that it was fitted to, or a holdout of the arm as it was: what was found is told, and no job passes."""
    healthy = _recording(ur5, 3, 0.2)
    assert healthy.dq is not None
    more = 6.0 * healthy.dq * (np.arange(6) == 2)  # viscous friction of joint 3
    changed, old = _csv(replace(healthy, effort=healthy.effort + more), tmp_path / "changed.csv"), tmp_path / "old.csv"
    _csv(_recording(ur5, 4, 0.2), old)
    alone, lost = (
        tmp_path / "alone.json",
        [_csv(_recording(ur5, seed, 0.2), tmp_path / f"{seed}.csv") for seed in (1, 2)],
    )
    assert run(["identify", *map(str, lost), "--robot", "ur5", "--out", str(alone)]) == 0
    for one in lost:
        one.unlink()
    held = ["--model", str(model), "--holdout", str(old)]
    for options, says, told in (
        (["--model", str(alone)], "not at hand", "or was missing from it already: viscous_friction (joint 3)"),
        (held, "recorded before the change", "nothing that these recordings can prove"),
    ):
        capsys.readouterr()
        assert run(["diagnose", str(changed), *options, "--fail-on", "cause"]) == 2
        out = capsys.readouterr()
        assert says in " ".join(out.err.split())
        assert told in " ".join(out.out.split())
    assert run(["diagnose", "--model", str(model), str(changed), "--fail-on", "cause"]) == 4
