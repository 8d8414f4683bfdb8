"""The pages on other programs run as they stand, and what they compute there is the model's torque."""

from __future__ import annotations

import contextlib
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

import physident as pid
from physident.cli import run
from physident.effects.friction import StribeckFriction
from physident.estimation.estimate import as_estimate
from tests.conftest import ROOT
from tests.exported_arms import physical_model

BLOCK = re.compile(r"^```(python|sh|cpp)\n(.*?)^```\n", flags=re.S | re.M)
RIGID = ("rigid_body", "rotor_inertia")
MAIN = """
#include <cstdio>
int main() {
  Feedforward arm;
  Feedforward::Joints q{%s}, v{%s}, a{%s};
  for (double tau : arm.torque(q, v, a)) std::printf("%%.17g\\n", tau);
}
"""


@pytest.fixture
def folder(tmp_path: Path, healthy_runs: list[pid.Recording]) -> Path:
    """A folder with the files that the pages start from."""
    plain = physical_model(pid.load_robot("ur5"), seed=31)
    effects = (*plain.effects, StribeckFriction((2,), (0.1,)))
    model = pid.Model(plain.robot, effects, np.append(plain.theta, 0.7))
    as_estimate(model, pid.Filter()).save(tmp_path / "model.json")
    as_estimate(plain, pid.Filter()).save(tmp_path / "before.json")
    pid.export_mjcf(physical_model(plain.robot, seed=32), tmp_path / "yours.xml")
    run_ = healthy_runs[2]
    table = np.column_stack([run_.time, run_.q, run_.effort])[:1500]
    names = [f"{name}_{j}" for name in ("q", "tau") for j in range(1, 7)]
    np.savetxt(tmp_path / "run.csv", table, delimiter=",", header=",".join(["time", *names]), comments="")
    return tmp_path


def played(page: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Run the commands and the Python of a page in a folder; returns its names, and its C++ as "cpp"."""
    names: dict[str, Any] = {}
    monkeypatch.syspath_prepend(str(folder))
    for module in ("arm", "arm_effects"):
        monkeypatch.delitem(sys.modules, module, raising=False)
    with contextlib.chdir(folder):
        for kind, text in BLOCK.findall((ROOT / "docs" / "how-to" / page).read_text(encoding="utf-8")):
            if kind == "sh":
                assert all(run(shlex.split(line)[1:]) == 0 for line in text.splitlines()), text
            elif kind == "python":
                exec(compile(text, page, "exec"), names)
            else:
                names["cpp"] = text
    return names


def torque(folder: Path, effects: tuple[str, ...], q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
    """What the model's effects of these names need (6,), or all effects of the plant for none."""
    model = pid.load_estimate(folder / "model.json").model
    parts = [(e, t) for e, t in model.effect_parameters() if (e.name in effects if effects else e.acts_on == "plant")]
    chosen = pid.Model(model.robot, tuple(e for e, _ in parts), np.concatenate([t for _, t in parts]))
    return chosen.torque(pid.Signals.of_states(q, v, a))[0]


@pytest.mark.slow
def test_mujoco(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    try:
        names = played("mujoco.md", folder, monkeypatch)
    finally:
        mujoco.set_mjcb_passive(None)
    q, v = [0.0, -1.0, 1.2, 0.1, 0.5, 0.0], [0.2, -0.3, 0.4, 0.5, -0.6, 0.7]
    expected = torque(folder, (), *(np.array(x, dtype=float) for x in (q, v, np.ones(6))))
    # MuJoCo's dry friction is a constraint, whose impedance of 0.9999 leaves a ten-thousandth
    np.testing.assert_allclose(names["torque"], expected, atol=1e-3 * np.abs(expected).max())
    assert all((folder / name).stat().st_size > 1000 for name in ("patched.xml", "replay.png", "replay.rrd"))


def test_pinocchio(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    names = played("pinocchio.md", folder, monkeypatch)
    state = names["q"], names["v"], names["a"]
    np.testing.assert_allclose(names["torque"], torque(folder, RIGID, *state), rtol=1e-9, atol=1e-9)
    whole = pid.load_estimate(folder / "model.json").model.torque(pid.Signals.of_states(*state))[0]
    np.testing.assert_allclose(names["torque"] + names["friction"], whole, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(names["acceleration"], names["a"], rtol=1e-6, atol=1e-6)


@pytest.mark.skipif(shutil.which("g++") is None, reason="no C++ compiler (g++) on this machine")
def test_ros2_control(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    code = played("ros2-control.md", folder, monkeypatch)["cpp"]
    q, v, a = np.random.default_rng(33).uniform(-1, 1, size=(3, 6))
    (folder / "main.cpp").write_text(code + MAIN % tuple(", ".join(map(repr, x.tolist())) for x in (q, v, a)))
    subprocess.run(["gcc", "-O1", "-Wall", "-c", "arm.c"], cwd=folder, check=True, timeout=120)
    flags = ["-std=c++17", "-O1", "-Wall", "-Wextra", "-Werror"]
    subprocess.run(["g++", *flags, "main.cpp", "arm.o", "-o", "main"], cwd=folder, check=True, timeout=120)
    printed = subprocess.run([str(folder / "main")], check=True, capture_output=True, text=True, timeout=20).stdout
    whole = pid.load_estimate(folder / "model.json").model.torque(pid.Signals.of_states(q, v, a))[0]
    np.testing.assert_allclose(np.array(printed.split(), dtype=float), whole, rtol=1e-12)


def test_drake(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pydrake", reason="Drake is not installed (pip install drake)")
    names = played("drake.md", folder, monkeypatch)
    state = names["q"], names["v"], names["a"]
    damping = re.findall(r'damping="([^"]+)"', (folder / "arm.urdf").read_text(encoding="utf-8"))
    expected = torque(folder, RIGID, *state) + np.array(damping, dtype=float) * names["v"]
    np.testing.assert_allclose(names["torque"], expected, rtol=1e-6, atol=1e-6)


def test_every_program_is_linked_from_the_overview() -> None:
    overview = (ROOT / "docs" / "how-to" / "use-a-model-elsewhere.md").read_text(encoding="utf-8")
    assert all(f"({page})" in overview for page in ("mujoco.md", "pinocchio.md", "drake.md", "ros2-control.md"))
