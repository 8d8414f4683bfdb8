"""A number that differs between a MuJoCo file and the recorded arm is found by a diagnosis against that file."""

from __future__ import annotations

import json
from pathlib import Path

import mujoco
import numpy as np
import pytest

from physident.cli import run
from tests.vendor_robots import mjcf

Array = np.ndarray


def record(text: str, seed: int, duration: float = 15.0) -> Array:
    """Rows time, q, dq, tau of a MuJoCo arm that follows a multisine, of its actuators' torques with noise."""
    model = mujoco.MjModel.from_xml_string(text)
    data, wanted, n = mujoco.MjData(model), mujoco.MjData(model), model.nv
    rng = np.random.default_rng(seed)
    rates = 2 * np.pi * 0.1 * np.arange(1, 6)
    sines, cosines = 0.5 * rng.normal(size=(2, n, 5)) / np.arange(1, 6)

    def reference(t: float) -> Array:
        rise = np.clip([(t - 0.5) / 2, (duration - 0.5 - t) / 2], 0, 1)
        envelope = np.prod(rise**3 * (10 - 15 * rise + 6 * rise**2))
        return envelope * (sines @ np.sin(rates * t) + cosines @ np.cos(rates * t))

    rows, h = [], 1e-4
    for k in range(int(duration / model.opt.timestep)):
        t = k * model.opt.timestep
        before, now, after = reference(t - h), reference(t), reference(t + h)
        wanted.qpos[:], wanted.qvel[:] = now, (after - before) / (2 * h)
        wanted.qacc[:] = (after - 2 * now + before) / h**2
        mujoco.mj_inverse(model, wanted)
        torque = wanted.qfrc_inverse + 400 * (now - data.qpos) + 40 * (wanted.qvel - data.qvel)
        data.ctrl[:] = torque / model.actuator_gear[:, 0]
        measured = np.concatenate([[t], data.qpos, data.qvel, torque])
        mujoco.mj_step(model, data)
        if k % 5 == 0:
            rows.append(measured)
    table = np.array(rows)
    table[:, 1:] += rng.normal(size=(len(table), 3 * n)) * np.repeat([1e-5, 1e-3, 0.05], n)
    return table


def written(folder: Path, name: str, table: Array) -> str:
    n = table.shape[1] // 3
    head = ",".join(["time", *(f"{kind}_{j}" for kind in ("q", "dq", "tau") for j in range(1, n + 1))])
    np.savetxt(folder / name, table, delimiter=",", header=head, comments="", fmt="%.9g")
    return str(folder / name)


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    folder = tmp_path_factory.mktemp("runs")
    return [written(folder, f"run_{seed}.csv", record(mjcf(), seed)) for seed in (1, 2)]


@pytest.mark.parametrize(
    ("changed", "effect", "value"),
    [
        ({"damping": 12.0}, "viscous_friction", 8.0),
        ({"friction": 6.0}, "coulomb_friction", 4.0),
        ({"mass": 5.0}, "link_inertia", None),
    ],
    ids=["damping", "frictionloss", "mass"],
)
def test_a_changed_number_is_named_first(
    changed: dict[str, float], effect: str, value: float | None, runs: list[str], tmp_path: Path
) -> None:
    """The arm has the number of the recording, its file another; the finding's value is the recorded arm's."""
    path = tmp_path / "arm.xml"
    path.write_text(mjcf(**changed))  # pyright: ignore[reportArgumentType]
    assert run(["diagnose", "--robot", str(path), *runs, "--json", str(tmp_path / "found.json")]) == 0
    found = json.loads((tmp_path / "found.json").read_text(encoding="utf-8"))
    first = found["findings"][0]
    assert first["effect"] == effect
    assert first["joints"] == [3]
    if value is not None:
        assert first["parameters"][0]["value"] == pytest.approx(value, rel=0.02)
