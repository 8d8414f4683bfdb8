"""Figures show the numbers they are made of, with units, whatever the names in them."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import physident as pid
from physident.cli import run
from physident.effects.contact import Contact
from physident.graphics import style
from physident.validation.comparison import contact_bands, predict_pair
from tests.test_report import made


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, ur5: pid.Robot) -> Path:
    """A recording with load-dependent friction on joint 2, one that nobody fits, and two models of the first."""
    folder = tmp_path_factory.mktemp("plots")
    for seed, name in enumerate(("one", "two")):
        made(ur5, folder / f"{name}.csv", seed)
    runs = pid.load_recordings(folder / "one.csv")
    pid.identify(ur5, runs).save(folder / "before.json")
    effects = ["rigid_body", "rotor_inertia", "viscous_friction", "coulomb_friction", "torque_offset"]
    pid.identify(ur5, runs, effects=[*effects, "load_dependent_friction"]).save(folder / "after.json")
    return folder


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The figures that were saved, while files are written as ever."""
    figures: list[Any] = []
    save = style.save

    def kept(figure: Any, path: Path) -> None:
        figures.append(figure)
        save(figure, path)

    monkeypatch.setattr(style, "save", kept)
    return figures


def test_compare_draws_what_either_model_leaves(folder: Path, drawn: list[Any]) -> None:
    models = ["--model", str(folder / "before.json"), "--model", str(folder / "after.json")]
    out = folder / "compare.png"
    assert run(["compare", *models, "--on", str(folder / "two.csv"), "--plot", str(out)]) == 0
    assert out.read_bytes().startswith(b"\x89PNG")
    (figure,) = drawn
    before, after = (pid.load_estimate(folder / f"{name}.json") for name in ("before", "after"))
    gain = pid.compare(before, after, on=pid.load_recordings(folder / "two.csv"))
    axis = figure.axes[1]
    lines = {line.get_label(): np.asarray(line.get_ydata()) for line in axis.get_lines()}
    for name, score in (("model as it was", gain.before), ("extended model", gain.after)):
        assert np.sqrt(np.mean(lines[name] ** 2)) == pytest.approx(score.rms[1], rel=1e-6)
    assert f"{gain.before.rms[1]:.3g} to {gain.after.rms[1]:.3g} N m" in axis.get_title(loc="left")
    assert axis.get_ylabel() == "residual [N m]"
    assert figure.axes[-1].get_xlabel().endswith("[s]")


@pytest.mark.slow
def test_diagnose_draws_its_answer_on_what_nobody_fitted(folder: Path, drawn: list[Any]) -> None:
    out, data = folder / "diagnose.svg", folder / "d.json"
    command = ["diagnose", "--model", str(folder / "before.json"), str(folder / "one.csv")]
    assert run([*command, "--holdout", str(folder / "two.csv"), "--plot", str(out), "--json", str(data)]) == 0
    (figure,) = drawn
    assert figure.get_suptitle().startswith("The model lacks load-dependent friction on joint 2.")
    import json

    score = json.loads(data.read_text())["score"]
    sizes = [np.sqrt(np.mean(np.asarray(line.get_ydata()) ** 2)) for line in figure.axes[1].get_lines()]
    np.testing.assert_allclose(sizes, [score[key]["rms"][1] for key in ("before", "after")], rtol=1e-6)


@pytest.mark.parametrize(
    "command",
    [
        lambda f: ["inspect", str(f / "one.csv")],
        lambda f: ["validate", "--model", str(f / "before.json"), str(f / "two.csv")],
        lambda f: ["compare", *2 * ["--model", str(f / "before.json")], "--on", str(f / "two.csv")],
        lambda f: ["diagnose", "--model", str(f / "before.json"), str(f / "one.csv")],
    ],
    ids=["inspect", "validate", "compare", "diagnose"],
)
def test_a_figure_of_no_known_kind_is_refused_before_any_work(
    folder: Path, capsys: pytest.CaptureFixture[str], command: Callable[[Path], list[str]]
) -> None:
    assert run([*command(folder), "--plot", str(folder / "figure.bmp")]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert "no known ending" in printed.err
    assert not (folder / "figure.bmp").exists()


def test_signs_of_formulas_in_names_are_shown_as_they_are(folder: Path, drawn: list[Any]) -> None:
    odd = folder / "run $x^$ _1_.csv"
    shutil.copy(folder / "one.csv", odd)
    assert run(["inspect", str(odd), "--plot", str(folder / "inspect.png")]) == 0
    assert drawn[0].axes[0].get_title(loc="left") == odd.name
    estimate = pid.load_estimate(folder / "before.json")
    text = estimate.model.robot.urdf.replace("elbow_joint", "$elbow^$")
    renamed = pid.load_robot(str(_written(folder / "renamed.urdf", text)))
    pair = predict_pair(pid.Model.nominal(renamed), None, [pid.load_recording(odd)], estimate.filter)
    from physident.graphics.figures.residual import plot_residuals

    plot_residuals(pair, renamed, folder / "odd.png", head="$a^$")
    assert "$elbow^$" in drawn[1].axes[2].get_title(loc="left")


def _written(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


def test_a_contact_lies_where_the_recording_had_it(folder: Path) -> None:
    """Its band counts seconds in motion over recordings end to end, and only the recording that it belongs to."""
    one, two = (pid.load_recording(folder / f"{name}.csv") for name in ("one", "two"))
    estimate = pid.load_estimate(folder / "before.json")
    pair = predict_pair(estimate, None, [one, two], estimate.filter)
    touched = Contact(intervals=((5.0, 6.0),), recording=two.sha256)
    model = pid.Model(estimate.model.robot, (*estimate.model.effects, touched), np.append(estimate.theta, np.zeros(6)))
    ((start, end),) = contact_bands(model, pair.before, [one, two])
    p = pair.before
    rows = np.flatnonzero(p.recording == 1)
    expected = (rows[0] + np.searchsorted(p.time[rows], 5.0)) / p.rate
    assert start == pytest.approx(expected, abs=1.5 / p.rate)
    assert end - start == pytest.approx(1.0, abs=2 / p.rate)
    assert contact_bands(estimate.model, p, [one, two]) == ()
    assert len(p.rms) == 6


def test_colours_of_a_figure_are_told_apart_without_red_or_green() -> None:
    """Machado et al. (2009), eq. 6: what remains of a colour for a dichromat; distances in linear RGB stay apart."""
    protan = np.array([[0.152, 1.053, -0.205], [0.115, 0.786, 0.099], [-0.004, -0.048, 1.052]])
    deutan = np.array([[0.367, 0.861, -0.228], [0.280, 0.673, 0.047], [-0.012, 0.043, 0.969]])
    used = [style.MEASURED, style.AS_IT_WAS, style.EXTENDED, style.OTHER]
    rgb = np.array([[int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)] for colour in used])
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    for seen in (np.eye(3), protan, deutan):
        shown = linear @ seen.T
        apart = np.linalg.norm(shown[:, None] - shown[None], axis=2)[np.triu_indices(len(used), 1)]
        assert apart.min() > 0.2


def test_curves_are_drawn_into_axes_of_the_user(folder: Path) -> None:
    from matplotlib.figure import Figure

    before, after = (pid.load_estimate(folder / f"{name}.json") for name in ("before", "after"))
    run_ = pid.load_recording(folder / "two.csv")
    axes = Figure().subplots(1, 3)
    pid.draw_recording(axes[0], run_, "effort")
    pid.draw_prediction(axes[1], before, run_, joint=2)
    pid.draw_residual(axes[2], before, after, run_, joint=2)
    assert len(axes[0].get_lines()) == 6
    np.testing.assert_array_equal(axes[0].get_lines()[3].get_ydata(), run_.effort[:, 3])
    lines = {line.get_label(): np.asarray(line.get_ydata()) for line in axes[1].get_lines()}
    np.testing.assert_allclose(lines["measured"] - lines["predicted"], lines["residual"])
    gain = pid.compare(before, after, on=run_)
    for line, score in zip(axes[2].get_lines(), (gain.before, gain.after), strict=True):
        assert np.sqrt(np.mean(np.asarray(line.get_ydata()) ** 2)) == pytest.approx(score.rms[1], rel=1e-6)
    with pytest.raises(pid.InputError, match="joint is 7, expected a number from 1 to 6"):
        pid.draw_prediction(axes[1], before, run_, joint=7)
    with pytest.raises(pid.InputError):
        pid.draw_recording(axes[0], run_, "torques")  # pyright: ignore[reportArgumentType]
