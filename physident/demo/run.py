"""The demo: identify an arm, change it, diagnose it, and reveal the change."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path
from shlex import quote

import numpy as np

from physident.demo.arms import Truth, healthy_arm, hide
from physident.diagnosis.diagnose import diagnose_motion
from physident.diagnosis.result.diagnosis import Diagnosis
from physident.dynamics.model import Model
from physident.errors import InputError
from physident.estimation.identify import identify
from physident.excitation.motion.trajectory import random_trajectory
from physident.files import read_json, write_json
from physident.recordings.formats.csv import write_csv
from physident.recordings.load import load_recordings
from physident.robots.load import load_robot
from physident.simulation.sensors import Sensors
from physident.simulation.simulate import Simulation

SENSORS = Sensors(
    encoder_step=2 * np.pi / 2**17, velocity_noise=2e-3, torque_noise=(1.5, 2.0, 1.2, 0.3, 0.3, 0.25)
)  # encoders of a UR5, and torque noise as from its motor currents
DURATION = 20.0  # s
BEFORE = ("before_1.csv", "before_2.csv")
NOW = ("now_1.csv", "now_2.csv")
UNSEEN = "now_unseen.csv"
RESULTS = ("model.json", "diagnosis.json", "extended.json", "report.html", "session.rrd")
FILES = (*BEFORE, *NOW, UNSEEN, *RESULTS)
LIST, LIST_SCHEMA, MAX_LIST = "demo.json", "physident.demo/1", 100_000  # bytes


@dataclass(frozen=True, eq=False)
class Demo:
    """The results of the demo: the diagnosis, the hidden truth, and the files to open."""

    diagnosis: Diagnosis
    truth: Truth
    folder: Path
    files: tuple[Path, ...]

    @property
    def named(self) -> bool:
        """Whether the hidden effect is among the findings, on its joints."""
        return any((f.effect, f.joints) == (self.truth.effect, self.truth.joints) for f in self.diagnosis.findings)

    def __repr__(self) -> str:
        folder = self.folder
        runs = " ".join(str(folder / name) for name in NOW)
        command = f"physident diagnose --model {folder / 'model.json'} {runs} --holdout {folder / UNSEEN} --json {folder / 'diagnosis.json'}"
        verdict = "named" if self.named else "NOT named"
        return "\n".join(
            [
                f"A generated UR5 was identified on {' and '.join(BEFORE)}. Something in it has changed since.",
                f"$ {command}",
                "",
                repr(self.diagnosis),
                "",
                f"the truth, {verdict} above: {self.truth!r}",
                "",
                *(f"open: {_opened(path)}" for path in self.files),
            ]
        )


def run_demo(folder: str | Path = "demo", seed: int = 0) -> Demo:
    """Simulate recordings of a UR5 before and after a change that the ``seed`` draws, identify a model, and diagnose it.

    Writes recordings, models, diagnosis, report and rerun session into ``folder``, which is created. Raises InputError where
    the folder has a file of such a name that no demo wrote, or that has changed since.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    _refuse_foreign_files(folder)
    try:
        return _run(folder, seed)
    finally:
        _list_files(folder)


def _opened(path: Path) -> str:
    """A file, and what opens it."""
    return f"{path} with: rerun {quote(str(path))}" if path.suffix == ".rrd" else f"{path} in a browser"


def write_recordings(folder: str | Path = "demo", seed: int = 0) -> Truth:
    """Simulate and write the demo's five recordings alone, and return the hidden change; raises InputError as ``run_demo``."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    _refuse_foreign_files(folder)
    try:
        return _record(folder, seed)
    finally:
        _list_files(folder)


def _record(folder: Path, seed: int) -> Truth:
    arm = healthy_arm(load_robot("ur5"))
    truth = hide(arm, seed)
    for k, name in enumerate(BEFORE):
        _write_recording(arm, folder / name, 10 * seed + k)
    for k, name in enumerate((*NOW, UNSEEN)):
        _write_recording(truth.arm, folder / name, 10 * seed + 5 + k)
    return truth


def _run(folder: Path, seed: int) -> Demo:
    from physident.graphics.view import view
    from physident.report.page import write_report

    truth = _record(folder, seed)
    recordings = load_recordings([folder / name for name in (*BEFORE, *NOW, UNSEEN)])
    before, (*now, unseen) = recordings[:2], recordings[2:]
    estimate = identify(load_robot("ur5"), before)
    estimate.save(folder / "model.json")
    diagnosis = diagnose_motion(estimate, now, [unseen])
    extended = str(folder / "extended.json") if diagnosis.estimate is not None else None
    # so that advice, and the command that diagnoses again, can be typed as they are printed
    diagnosis = replace(diagnosis, model_file=str(folder / "model.json"), extended_file=extended)
    diagnosis.save(folder / "diagnosis.json")
    if diagnosis.estimate is not None:
        diagnosis.estimate.save(folder / "extended.json")
    report, session = folder / "report.html", folder / "session.rrd"
    write_report(folder / "diagnosis.json", report)
    models = [estimate] if diagnosis.estimate is None else [estimate, diagnosis.estimate]
    view(models, [*now, unseen], diagnosis, to=session)
    return Demo(diagnosis, truth, folder, (report, session))


def _refuse_foreign_files(folder: Path) -> None:
    """A file of the demo's names may be the user's: only those that an earlier demo listed are replaced."""
    listed, mine = folder / LIST, {}
    if listed.exists():
        data = read_json(listed, MAX_LIST, "the list of a demo's files", LIST_SCHEMA)
        mine = data["sha256"] if isinstance(data.get("sha256"), dict) else {}
    for name in FILES:
        if (folder / name).exists() and mine.get(name) != _sha256(folder / name):
            raise InputError(f"{folder / name} exists, and no demo wrote it; expected a folder without it (--folder)")


def _list_files(folder: Path) -> None:
    """Write the list of the demo's files with their hashes, by which another demo knows them."""
    hashes = {name: _sha256(folder / name) for name in FILES if (folder / name).exists()}
    write_json(folder / LIST, {"schema": LIST_SCHEMA, "sha256": hashes})


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _write_recording(arm: Model, path: Path, seed: int) -> None:
    """Write a recording of 20 s along a random Fourier motion."""
    motion = random_trajectory(arm.robot, seed=seed, harmonics=5, base_frequency=0.1, duration=DURATION)
    write_csv(path, Simulation(arm, motion, None, SENSORS, seed=seed).table())
