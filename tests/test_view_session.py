"""A session holds what was measured and what models make of it: read back from the file, entity by entity."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rerun.chunk import RrdReader

import physident as pid
from physident.effects.contact import Contact
from physident.graphics import style
from physident.graphics.session.bands import contact_intervals
from physident.graphics.session.content import SessionContent
from physident.graphics.session.data import gather, moving_rms
from physident.graphics.session.log import rgb
from physident.validation.predictions import predict

FAULT = (6.0, 8.0)  # s of the second recording, in which joint 2 needs 40 N m more
NAMES = ("default", "simple")


def made(robot: pid.Robot, seed: int, fault: tuple[float, float] | None) -> pid.Recording:
    """A recording of the nominal arm with friction, noise, and a fault of joint 2 for some seconds."""
    time, q, v, a = pid.random_trajectory(robot, seed=seed, duration=10.0).sample(125.0)
    torque = pid.Model.nominal(robot).torque(pid.Signals(time, q, v, a, rate=125.0)) + 3 * np.sign(v) + 2 * v
    torque += 0.2 * np.random.default_rng(seed).normal(size=torque.shape)
    if fault is not None:
        torque[(time > fault[0]) & (time < fault[1]), 1] += 40.0
    return pid.Recording(time, q, torque, "torque", dq=v, source=f"runs/{seed}.csv")


@pytest.fixture(scope="module")
def recordings(ur5: pid.Robot) -> list[pid.Recording]:
    return [made(ur5, 1, None), made(ur5, 2, FAULT)]


@pytest.fixture(scope="module")
def estimates(ur5: pid.Robot, recordings: list[pid.Recording]) -> dict[str, pid.Estimate]:
    simple = pid.identify(ur5, recordings[:1], effects=["rigid_body", "viscous_friction"])
    return {"default": pid.identify(ur5, recordings[:1]), "simple": simple}


@pytest.fixture(scope="module")
def session(
    tmp_path_factory: pytest.TempPathFactory,
    ur5: pid.Robot,
    recordings: list[pid.Recording],
    estimates: dict[str, pid.Estimate],
) -> Path:
    path = tmp_path_factory.mktemp("session") / "session.rrd"
    plan = pid.random_trajectory(ur5, seed=5)
    pid.view(estimates, recordings, to=path, plan=plan, progress=[300.0, 40.0, 25.0])
    return path


@pytest.fixture(scope="module")
def entities(session: Path) -> dict[str, dict[str, list[Any]]]:
    """Every entity of the session: its components' rows, and its times [s] under "time"."""
    reader = RrdReader(session)
    return read(reader, reader.recordings()[0])


def read(reader: RrdReader, store: Any) -> dict[str, dict[str, list[Any]]]:
    found: dict[str, dict[str, list[Any]]] = {}
    for chunk in reader.stream(store=store).to_chunks():
        batch, entity = chunk.to_record_batch(), found.setdefault(chunk.entity_path, {})
        for number, name in enumerate(batch.schema.names):
            column = batch.column(number)
            if name == "time":
                entity.setdefault("time", []).extend(np.asarray(column.cast("int64")) / 1e9)
            elif ":" in name:
                entity.setdefault(name, []).extend(column.to_pylist())
    return found


def curve(entities: dict[str, dict[str, list[Any]]], path: str) -> np.ndarray:
    return np.array([row[0] for row in entities[path]["Scalars:scalars"]], dtype=float)


def test_every_joint_has_its_curves_and_torques_add_up(entities: dict[str, dict[str, list[Any]]]) -> None:
    for j in range(1, 7):
        measured = curve(entities, f"/joints/{j}/torque/measured")
        for place, name in enumerate(NAMES, 1):  # later models are drawn above earlier ones
            predicted = curve(entities, f"/joints/{j}/torque/predicted/{place}_{name}")
            residual = curve(entities, f"/joints/{j}/residual/{place}_{name}")
            np.testing.assert_allclose(measured - predicted, residual, atol=1e-9)
            remainder = f"/joints/{j}/effects/{name}/0_remainder"
            np.testing.assert_array_equal(curve(entities, remainder), residual)  # such as a push that has no name
            parts = [p for p in entities if p.startswith(f"/joints/{j}/effects/{name}/") and p != remainder]
            np.testing.assert_allclose(sum(curve(entities, path) for path in parts), predicted, atol=1e-9)
            for path in parts:
                colour = entities[path]["SeriesLines:colors"][0][0]
                assert f"#{colour >> 8:06X}" == style.effect_colour(path.rsplit("/", 1)[1])


def test_torques_are_those_that_models_are_judged_on(
    entities: dict[str, dict[str, list[Any]]], estimates: dict[str, pid.Estimate], recordings: list[pid.Recording]
) -> None:
    for place, (name, estimate) in enumerate(estimates.items(), 1):
        p = predict(estimate, recordings)
        starts = np.array([0.0, recordings[0].duration + 1.0])
        time = np.array(entities["/joints/3/torque/measured"]["time"])
        for j in range(6):
            rows = np.isfinite(curve(entities, f"/joints/{j + 1}/torque/measured"))
            np.testing.assert_allclose(time[rows], p.time + starts[p.recording], atol=1e-8)
            np.testing.assert_allclose(curve(entities, f"/joints/{j + 1}/torque/measured")[rows], p.measured[:, j])
            np.testing.assert_allclose(
                curve(entities, f"/joints/{j + 1}/torque/predicted/{place}_{name}")[rows], p.predicted[:, j], atol=1e-9
            )


def test_the_recordings_do_not_run_into_each_other(entities: dict[str, dict[str, list[Any]]]) -> None:
    values = curve(entities, "/joints/1/residual/1_default")
    time = np.array(entities["/joints/1/residual/1_default"]["time"])
    (gap,) = np.flatnonzero(np.isnan(values))
    assert time[gap - 1] < 10.0
    assert time[gap + 1] > 11.0
    assert (np.diff(time) > 0).all()
    states = entities["/bands/recording"]
    assert [row[0] for row in states["StateChange:state"]] == ["1.csv", "-", "2.csv", "-"]
    np.testing.assert_allclose(states["time"], [0, 10, 11, 21])


def test_a_link_is_coloured_where_its_joint_has_a_residual(entities: dict[str, dict[str, list[Any]]]) -> None:
    (name,) = [n for n in entities["/robot/link_2/shape_0"] if n.endswith(":colors")]
    orange = np.array(rgb(style.RESIDUAL))

    def distance(link: int, at: float) -> float:
        entity = entities[f"/robot/link_{link}/shape_0"]
        row = int(np.searchsorted(entity["time"], at)) - 1
        colour = entity[name][row][0]
        return float(np.abs(np.array([colour >> 24, colour >> 16 & 255, colour >> 8 & 255]) - orange).max())

    during, before = 11.0 + sum(FAULT) / 2, 5.0
    assert distance(2, during) < 30 < 120 < distance(2, before)


def test_a_session_opens_where_the_residual_is_largest(
    entities: dict[str, dict[str, list[Any]]], recordings: list[pid.Recording]
) -> None:
    tool = entities["/robot/tool"]
    assert tool["time"][0] == min(tool["time"]) == -1.0  # the viewer opens at the first instant
    during = [
        place for clock, place in zip(tool["time"], tool["Points3D:positions"], strict=True)
        if FAULT[0] - 0.5 <= clock - 11.0 <= FAULT[1] + 0.5
    ]  # fmt: skip
    apart = np.linalg.norm(np.array(during)[:, 0] - tool["Points3D:positions"][0][0], axis=1)
    assert apart.min() < 0.03  # a pose from the fault, between two of its frames


def test_the_arm_goes_where_it_was_recorded(
    entities: dict[str, dict[str, list[Any]]], ur5: pid.Robot, recordings: list[pid.Recording]
) -> None:
    import pinocchio as pin

    tool = entities["/robot/tool"]
    data = ur5.pinocchio.createData()
    for at in (0.0, 4.0, 15.0):
        row = int(np.argmin(np.abs(np.array(tool["time"]) - at)))
        one, clock = (recordings[0], tool["time"][row]) if at < 10.5 else (recordings[1], tool["time"][row] - 11.0)
        q = np.array([np.interp(clock, one.time, column) for column in one.q.T])
        pin.framesForwardKinematics(ur5.pinocchio, data, q)
        last = data.oMf[ur5.pinocchio.nframes - 1].translation
        np.testing.assert_allclose(tool["Points3D:positions"][row][0], last, atol=1e-4)


def test_no_view_opens_empty(session: Path, entities: dict[str, dict[str, list[Any]]]) -> None:
    reader = RrdReader(session)
    blueprint = read(reader, reader.blueprints()[0])
    views = {path: entity for path, entity in blueprint.items() if "ViewBlueprint:space_origin" in entity}
    assert len(views) > 40
    for path, view in views.items():
        origin = view["ViewBlueprint:space_origin"][0][0]
        for query in blueprint[f"{path}/ViewContents"]["ViewContents:query"][0]:
            root = query.replace("$origin", origin).removesuffix("/**")
            held = [e for e in entities if e == root or e.startswith(f"{root}/")]
            assert held, f"{view['ViewBlueprint:display_name']} shows {root}, where nothing is"


def test_contacts_lie_on_the_session_clock(ur5: pid.Robot, recordings: list[pid.Recording]) -> None:
    touched = Contact(intervals=((1.0, 2.0), (4.0, 4.5)), recording=recordings[1].sha256)
    model = pid.Model.nominal(ur5, [touched])
    data = gather(recordings, {}, ur5, pid.Filter())
    np.testing.assert_allclose(contact_intervals(data, model), [(12.0, 13.0), (15.0, 15.5)])
    assert contact_intervals(gather(recordings[:1], {}, ur5, pid.Filter()), model) == []


def test_the_moving_rms_is_that_of_its_window() -> None:
    rng = np.random.default_rng(1)
    values, time = rng.normal(size=(50, 2)), np.sort(rng.uniform(0, 10, 50))
    values[10:14, 0] = np.nan
    found = moving_rms(values, time, 1.5)
    for k in range(50):
        near = values[np.abs(time - time[k]) <= 0.75]
        expected = np.sqrt(np.nanmean(near**2, axis=0))
        expected[np.isnan(values[k])] = np.nan
        np.testing.assert_allclose(found[k], expected)


def test_a_session_that_fails_leaves_what_was_there(
    tmp_path: Path, ur5: pid.Robot, recordings: list[pid.Recording]
) -> None:
    from physident.graphics.session.write import write_session

    path = tmp_path / "session.rrd"
    path.write_text("kept")
    other = replace(recordings[0], q=recordings[0].q[:, :3], dq=None, effort=recordings[0].effort[:, :3])
    with pytest.raises(pid.InputError, match="3 joints"):
        write_session(SessionContent(ur5, (other,)), path)
    with pytest.raises(pid.InputError, match=r"expected \.rrd"):
        write_session(SessionContent(ur5, tuple(recordings)), tmp_path / "session.txt")
    with pytest.raises(pid.InputError, match="nothing to show"):
        write_session(SessionContent(ur5), path)
    assert [p.name for p in tmp_path.iterdir()] == ["session.rrd"]
    assert path.read_text() == "kept"
