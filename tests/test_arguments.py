"""Every public function with arguments of the wrong kind, swapped, missing, single instead of several: it works, or says in one line what is wrong."""

from __future__ import annotations

import inspect
import itertools
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from matplotlib.figure import Figure

import physident as pid
from tests.test_identify import _recording

BRIEF = 0.1  # s: what computes for so long was accepted
LONG = ("diagnose", "diagnose_motion")
FUNCTIONS = [name for name in pid.__all__ if inspect.isfunction(getattr(pid, name))]


class _Accepted(BaseException):
    """The time is over."""


def _accept(*_: object) -> None:
    raise _Accepted


@pytest.fixture(scope="module")
def things(ur5: pid.Robot, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """One thing of every kind that a user may hold, by the names of parameters."""
    folder = tmp_path_factory.mktemp("things")
    recording, other = (_recording(ur5, seed, 0.2) for seed in (1, 2))
    estimate = pid.identify(ur5, recording)
    estimate.save(folder / "model.json")
    signals, filter = pid.prepare(recording, pid.Filter()), pid.Filter()
    trajectory = pid.random_trajectory(ur5, seed=0)
    return {
        "robot": ur5, "recording": recording, "recordings": [other], "estimate": estimate, "model": estimate.model,
        "signals": [signals], "filter": filter, "trajectory": trajectory, "effects": estimate.model.effects,
        "regressor": pid.build_regressor(ur5, estimate.model.effects, [signals], filter),
        "text": "x", "number": 3, "fraction": 0.5, "minus": -1, "nan": float("nan"), "huge": 10**30, "none": None,
        "nothing": [], "texts": ["x"], "nested": [[recording]], "mapping": {}, "array": np.zeros((3, 2)), "no text": "",
        "yes": True, "model file": folder / "model.json",
    }  # fmt: skip


def _file(recording: pid.Recording, folder: Path) -> Path:
    table = np.column_stack([recording.time, recording.q, recording.effort])
    names = ["time", *(f"{kind}_{j}" for kind in ("q", "tau") for j in range(1, 7))]
    np.savetxt(folder / "a.csv", table, delimiter=",", header=",".join(names), comments="")
    return folder / "a.csv"


def calls(things: dict[str, Any], folder: Path) -> dict[str, dict[str, Any]]:
    """Arguments with which each public function works, or computes for long."""
    axes = Figure().subplots()
    t = things
    out = {name: folder / name for name in ("a.urdf", "a.xml", "a.c", "a.casadi", "a.py", "a.json", "a.html", "a.rrd")}
    diagnosis = {
        "model": t["estimate"],
        "recordings": t["recordings"],
        "holdout": (),
        "filter": None,
        "seed": 0,
        "columns": None,
    }
    design = {"limits": "joint", "base_frequency": 0.2, "seed": 0, "table": None, "clearance": 0.02, "meshes": None}
    search = {"harmonics": 2, "periods": 1, "starts": 1, "generations": 1}
    reading = {"columns": None, "drive_gains": None, "topic": None, "rate": None, "joints": None}
    robot, model, estimate, rest = t["robot"], t["model"], t["estimate"], t["recordings"]
    return {
        "find_base_parameters": {"robot": robot, "effects": t["effects"], "seed": 0},
        "make_effects": {"effects": "rigid_body"},
        "diagnose": diagnosis | {"recording_offsets": False, "before": None},
        "diagnose_motion": diagnosis | {"recording_offsets": False, "before": None},
        "diagnose_at_rest": {"model": estimate, "recordings": rest},
        "load_estimate": {"path": t["model file"]},
        "identify_drive_gains": {"robot": robot, "unloaded": t["recording"], "loaded": rest, "load_mass": 1.0, "method": "tls", "effects": "rigid_body", "filter": None},
        "identify": {"robot": robot, "recordings": rest, "effects": "rigid_body", "method": "wls", "filter": None, "columns": None},
        "design_trajectory": design | search | {"source": robot, "criterion": "condition"},
        "design_discriminating": design | search | {"source": estimate, "effect_a": "coulomb_friction", "effect_b": "viscous_friction", "joint": 2, "noise": None},
        "design_covering": design | search | {"estimate": estimate, "effect": "learned_position", "joint": 2},
        "design_session": design | {"source": robot, "load": None, "motions": 1, "speeds": (1.0,)},
        "load_trajectory": {"path": t["path"]},
        "load_effects": {"path": t["path"]},
        "random_trajectory": {"robot": robot, "seed": 0, "harmonics": 5, "base_frequency": 0.1, "duration": None, "scale": 0.8},
        "export_urdf": {"model": model, "path": out["a.urdf"]},
        "export_mjcf": {"model": model, "path": out["a.xml"], "meshes": None},
        "patch_mjcf": {"model": model, "source": t["path"], "target": None},
        "export_c": {"model": model, "path": out["a.c"]},
        "export_casadi": {"model": model, "path": out["a.casadi"]},
        "export_python": {"model": model, "path": out["a.py"]},
        "export_parameters": {"estimate": estimate, "path": out["a.json"]},
        "measure_identifiability": {"robot": robot, "signals": t["signals"], "filter": t["filter"], "baseline": None},
        "inspect_recording": {"recording": t["recording"]},
        "measure_manipulability": {"robot": robot, "q": t["recording"].q[:9]},
        "load_recording": reading | {"path": t["path"]},
        "load_recordings": reading | {"paths": t["path"]},
        "write_report": {"diagnosis": t["path"], "out": out["a.html"], "command": ""},
        "build_regressor": {"robot": robot, "effects": t["effects"], "signals": t["signals"], "filter": t["filter"], "moving_only": True, "theta": None, "model": None},
        "identify_payload": {"estimate": estimate, "recordings": rest, "seed": 0},
        "load_robot": {"source": "ur5", "gravity": None, "joints": None, "lock": None, "tool": None},
        "check_setup": {"robot": robot, "recordings": rest},
        "simulate": {"model": model, "trajectory": t["trajectory"], "controller": None, "sensors": None, "extra_torque": None, "seed": 0, "step": 0.004},
        "prepare": {"recording": t["recording"], "filter": t["filter"]},
        "compare": {"before": estimate, "after": estimate, "on": rest, "include_fitted": True},
        "validate": {"estimate": estimate, "recordings": rest, "include_fitted": True},
        "view": {"models": estimate, "recordings": rest, "diagnosis": None, "to": out["a.rrd"], "plan": None, "robot": None, "cutoff": None, "meshes": None},
        "measure_visibility": {"regressor": t["regressor"]},
        "draw_recording": {"axes": axes, "recording": t["recording"], "channel": "effort"},
        "draw_prediction": {"axes": axes, "estimate": estimate, "recordings": rest, "joint": 2},
        "draw_residual": {"axes": axes, "before": estimate, "after": estimate, "recordings": rest, "joint": 2},
    }  # fmt: skip


def wrong(good: dict[str, Any], things: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    for a, b in itertools.combinations(good, 2):
        yield f"{a} and {b} swapped", good | {a: good[b], b: good[a]}
    for name in good:
        yield f"{name} missing", {key: value for key, value in good.items() if key != name}
        for kind, thing in things.items():
            yield f"{name} is {kind}", good | {name: thing}
    yield "another name", good | {"colour": "red"}


@contextmanager
def brief() -> Iterator[None]:
    before = signal.signal(signal.SIGALRM, _accept)
    signal.setitimer(signal.ITIMER_REAL, BRIEF)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.filterwarnings("ignore::physident.PhysidentWarning")
def test_every_call_works_or_says_in_one_line_what_is_wrong(
    name: str, things: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    things = things | {"path": _file(things["recording"], tmp_path)}
    function: Callable[..., Any] = getattr(pid, name)
    good = calls(things, tmp_path)[name]
    assert set(good) >= {p for p, one in inspect.signature(function).parameters.items() if one.default is one.empty and one.kind is not one.VAR_KEYWORD}  # fmt: skip
    monkeypatch.setattr("physident.excitation.design_trajectory.search", _accept)  # CasADi must not be interrupted
    if name not in LONG:  # and neither must imports
        with suppress(pid.PhysidentError, _Accepted):
            function(**good)
    for what, arguments in wrong(good, things):
        try:
            with suppress(_Accepted), nullcontext() if name.startswith("design") else brief():
                function(**arguments)
        except pid.PhysidentError as error:
            lines = str(error).splitlines()
        except Exception as error:
            raise AssertionError(f"{name}: {what}: {error!r}") from error
        else:
            lines = ["worked"]
        assert len(lines) == 1, what


def test_a_message_names_the_argument_what_came_and_what_was_expected(things: dict[str, Any]) -> None:
    robot, identify = things["robot"], cast(Any, pid.identify)
    for call, message in {
        lambda: pid.load_recording("a.csv", robot): "load_recording: columns is a Robot, expected text, a ColumnLayout or None",
        lambda: pid.identify(things["recording"], robot): "identify: robot is a Recording, expected a Robot, text or a path",
        lambda: identify(robot): "identify: missing a required argument: 'recordings'; expected identify(robot, recordings, effects, method, filter, columns)",
        lambda: pid.prepare(things["recordings"], things["filter"]): "prepare: recording is a list of Recording, expected a Recording",
        lambda: pid.load_robot(things["texts"]): "load_robot: source is a list of str, expected text or a path",
        lambda: pid.random_trajectory(robot, seed=-1): "random_trajectory: seed is -1, expected a whole number from 0 to 2^64",
    }.items():  # fmt: skip
        with pytest.raises(pid.InputError) as error:
            call()
        assert str(error.value) == message


def test_names_and_single_ones_stand_for_what_they_name(things: dict[str, Any], tmp_path: Path) -> None:
    recording, path = things["recording"], _file(things["recording"], tmp_path)
    assert pid.check_setup("ur5", recording) == pid.check_setup(pid.load_robot("ur5"), [recording])
    assert pid.check_setup(None, str(path)) == pid.check_setup(None, pid.load_recordings(path))
    plan = things["trajectory"]
    physical = pid.identify(things["robot"], recording, method=pid.Physical(resamples=0))
    of_estimate, of_model = (pid.simulate(one, plan, seed=1) for one in (physical, physical.model))
    np.testing.assert_array_equal(of_estimate.effort, of_model.effort)
    lunar: Any = np.array([0.0, 0.0, -1.62])
    gravity = pid.load_robot("ur5", lunar).gravity
    assert gravity == pid.load_robot("ur5", [0, 0, -1.62]).gravity
