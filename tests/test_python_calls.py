"""Calls as people type them in Python."""

from __future__ import annotations

import inspect
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from tests.test_identify import _recording


@pytest.fixture(scope="module")
def estimate(ur5: pid.Robot) -> pid.Estimate:
    return pid.identify(ur5, [_recording(ur5, 1, 0.2)])


def test_one_effect_and_a_cutoff_as_they_are(ur5: pid.Robot) -> None:
    recording = _recording(ur5, 1, 0.2)
    short = pid.identify(ur5, [recording], effects="rigid_body, viscous_friction", filter=8)
    long = pid.identify(ur5, [recording], ["rigid_body", "viscous_friction"], filter=pid.Filter(8.0))
    np.testing.assert_array_equal(short.theta, long.theta)
    assert short.filter.cutoff == 8.0
    for wrong in ("8", True, (8,)):
        with pytest.raises(pid.InputError, match=r"expected a (cutoff|Filter, a number or None)"):
            pid.identify(ur5, [recording], filter=wrong)  # pyright: ignore[reportArgumentType]


def test_parameters_by_name(estimate: pid.Estimate) -> None:
    assert estimate["viscous_friction_2"] == estimate.model.parameters("viscous_friction")[1]
    with pytest.raises(pid.InputError, match="did you mean 'viscous_friction_2'"):
        estimate["viscos_friction_2"]


def test_a_prediction_is_the_model_s_torque_through_the_filter(ur5: pid.Robot, estimate: pid.Estimate) -> None:
    recording = _recording(ur5, 2, 0.2)
    found, score = estimate.predict(recording), pid.validate(estimate, [recording])
    np.testing.assert_allclose(found.rms, score.rms, rtol=1e-12)
    signals = pid.prepare(recording, estimate.filter)
    torque = estimate.model.torque(signals)
    rate = signals.rate
    filtered = estimate.filter.apply(np.ascontiguousarray(torque.T), rate).T
    times = estimate.filter.apply(signals.time[None], rate)[0]
    rows = np.searchsorted(times, found.time - 1e-9)
    np.testing.assert_allclose(found.predicted, filtered[rows], atol=1e-8)


def test_values_as_a_frame_and_as_a_figure(estimate: pid.Estimate, tmp_path: Path) -> None:
    pd = pytest.importorskip("pandas", reason="pandas is optional")
    frame = estimate.to_frame()
    assert isinstance(frame, pd.DataFrame)
    row = frame.loc["coulomb_friction_3"]
    assert row["value"] == estimate["coulomb_friction_3"]
    assert row["low"] < row["value"] < row["high"]
    assert (row["joint"], row["unit"], row["effect"]) == (3, "N m", "coulomb_friction")
    figure = estimate.plot()
    figure.savefig(tmp_path / "values.png")
    assert "viscous friction" in " ".join(axes.get_title("left") for axes in figure.axes)


def test_an_estimate_is_exported_as_its_model(estimate: pid.Estimate, tmp_path: Path) -> None:
    pid.export_python(estimate, tmp_path / "a.py")
    pid.export_python(estimate.model, tmp_path / "b.py")
    assert (tmp_path / "a.py").read_text() == (tmp_path / "b.py").read_text()


def test_the_caller_s_arrays_stay_writable() -> None:
    time, q = np.arange(10.0), np.zeros((10, 2))
    recording = pid.Recording(time, q, q.copy(), "torque")
    q[0, 0] = 1.0
    assert recording.q[0, 0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        recording.q[0, 0] = 1.0
    theta = np.zeros(60)
    pid.Model(pid.load_robot("ur5"), pid.make_effects("rigid_body"), theta)
    theta[0] = 1.0


def test_printed_forms_fit_a_screen(ur5: pid.Robot, estimate: pid.Estimate) -> None:
    recording = _recording(ur5, 2, 0.2)
    signals = pid.prepare(recording, estimate.filter)
    regressor = pid.build_regressor(ur5, estimate.model.effects, [signals], estimate.filter)
    for thing in (estimate.model, signals, regressor, estimate.predict(recording), estimate, recording):
        lines = repr(thing).splitlines()
        assert len(lines) <= 30, type(thing)
        assert max(map(len, lines)) <= 160, type(thing)
        assert "array(" not in repr(thing)


def test_a_layout_of_files_is_not_called_columns(estimate: pid.Estimate) -> None:
    assert not hasattr(estimate, "columns")
    assert estimate.layout is None


def test_view_has_a_signature() -> None:
    assert list(inspect.signature(pid.view).parameters)[:3] == ["models", "recordings", "diagnosis"]


def test_type_checkers_follow_an_editable_install() -> None:
    """A path in site-packages is followed by type checkers; an import hook is not."""
    text = (Path(pid.__file__).parents[1] / "pyproject.toml").read_text()
    assert 'package-dir = { "" = "." }' in text
    assert (Path(pid.__file__).parent / "py.typed").exists()


def test_results_are_the_same_bytes_whatever_the_number_of_threads(tmp_path: Path) -> None:
    code = """
import sys, physident as pid
from tests.test_identify import _recording
ur5 = pid.load_robot("ur5")
pid.identify(ur5, [_recording(ur5, 1, 0.2)]).save(sys.argv[1])
"""
    written = []
    for threads in ("1", "2"):
        out = tmp_path / f"{threads}.json"
        env = {
            "OPENBLAS_NUM_THREADS": threads,
            "OMP_NUM_THREADS": threads,
            "PATH": "",
            "PYTHONPATH": ":".join(sys.path),
        }
        subprocess.run([sys.executable, "-c", code, str(out)], check=True, env=env)
        written.append(out.read_bytes())
    assert written[0] == written[1]
