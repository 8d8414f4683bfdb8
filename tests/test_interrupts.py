"""Ctrl-C: one line, exit code 130, no file - also while a library that would go on is at work."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import physident.excitation.design_trajectory
from physident.cli import run
from physident.excitation.limits.constraints import Constraints
from physident.excitation.search.ipopt import minimise


@pytest.fixture
def interruptible() -> Iterator[None]:
    """A process that a shell started in the background ignores interrupts; this test must not."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("interruptible")
def test_a_solver_is_stopped_at_once_and_the_interrupt_arrives() -> None:
    pattern = np.array([[0, 0], [1, 1]])
    rows = Constraints(np.full(2, -9.0), np.full(2, 9.0), pattern, lambda y: y, lambda _: np.ones(2))
    called = []

    def far(y: np.ndarray):  # Rosenbrock's valley: dozens of iterations from here
        called.append(y)
        if len(called) == 3:
            signal.raise_signal(signal.SIGINT)
        slope = np.array([-400 * y[0] * (y[1] - y[0] ** 2) - 2 * (1 - y[0]), 200 * (y[1] - y[0] ** 2)])
        return float(100 * (y[1] - y[0] ** 2) ** 2 + (1 - y[0]) ** 2), lambda: slope

    usual = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        minimise(far, rows, np.array([-5.0, 5.0]), 200)
    stopped_after = len(called)
    assert signal.getsignal(signal.SIGINT) is usual
    np.testing.assert_allclose(minimise(far, rows, np.array([-5.0, 5.0]), 200), [1.0, 1.0], atol=1e-2)
    assert stopped_after < (len(called) - stopped_after) / 2


def test_the_command_says_that_it_was_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture
) -> None:
    def stopped(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(physident.excitation.design_trajectory, "design_trajectory", stopped)
    assert run(["design", "--robot", "ur5", "--out", "plan.json", "--csv", "plan.csv"]) == 130
    out, err = capfd.readouterr()
    assert (out, err) == ("", "physident: stopped; no file was left half written\n")
    assert list(tmp_path.iterdir()) == []
