"""One simulated recording, the same free parameters: identified by physident, and by mujoco.sysid through simulations."""

from __future__ import annotations

import io
import logging
import tempfile
import time
from pathlib import Path

import mujoco
import numpy as np
from hidden import NAMES, RATE, described, record
from mujoco import sysid

import physident as pid
from physident.estimation.estimate import as_estimate
from physident.estimation.estimators import Physical
from physident.estimation.physical.bounds import Bound
from physident.replay.replay import replay
from physident.robots.inertia import link_parameters

Array = np.ndarray
PER_JOINT = {"armature": "rotor_inertia", "damping": "viscous_friction", "frictionloss": "coulomb_friction"}
SETTINGS = ((0.5, 1e-3), (1.0, 1e-3), (1.0, 5e-4))  # s: of mujoco.sysid, lengths of its stretches and its time step
MOST_ROUNDS = 12  # after nine the objective no longer falls
FLANGE = 0.6, (0.0, 0.0, 0.02), (1e-3, 1e-3, 1e-3)  # kg, m, kg m^2
LOAD = 1.8, (0.0, 0.06, 0.04), (0.02, 0.02, 0.01)  # what the hand carries more than described


def solid(mass: float, centre: tuple[float, float, float], inertia: tuple[float, float, float]) -> Array:
    """Link parameters (10,) of a body [kg, m, kg m^2] whose axes are those of its link."""
    x, body = np.array(centre), np.zeros((4, 4))
    second = np.diag(0.5 * sum(inertia) - np.array(inertia)) + mass * np.outer(x, x)
    body[:3, :3], body[:3, 3], body[3, :3], body[3, 3] = second, mass * x, mass * x, mass
    return link_parameters(body)


def with_links(robot: pid.Robot, links: Array, joints: Array) -> pid.Model:
    """A model of the file's four effects from link parameters (60,) and values of the joints (18,)."""
    return pid.Model(robot, pid.make_effects(NAMES), np.concatenate([links, joints]))


def start_and_truth() -> tuple[pid.Model, pid.Model]:
    """The described arm, with a flange, because mujoco.sysid needs a last link that is not thin; and the recorded arm,
    which has a load, and every joint parameter off by up to 60 %."""
    arm = described(True)
    links, joints = arm.theta[:60].copy(), arm.theta[60:]
    links[50:] += solid(*FLANGE)
    heavier = links.copy()
    heavier[50:] += solid(*LOAD)
    off = np.random.default_rng(0).uniform(0.6, 1.6, size=18)
    return with_links(arm.robot, links, joints), with_links(arm.robot, heavier, off * joints)


def by_physident(mine: Path, run: pid.Recording) -> tuple[pid.Model, float]:
    """The physical estimate that starts from an MJCF file, with all links but the last held at their described values."""
    begin = time.process_time()
    robot = pid.load_robot(mine)
    names = [c.name for c in pid.Model.nominal(robot, ["rigid_body"]).columns][:50]
    room = 1e-4 + 5e-3 * np.abs(robot.nominal[:50])
    ends = zip(names, robot.nominal[:50] - room, robot.nominal[:50] + room, strict=True)
    held = tuple(Bound(name, float(low), float(high)) for name, low, high in ends)
    found = pid.identify(robot, run, NAMES, Physical(bounds=held, resamples=0))
    return found.model, time.process_time() - begin


def study() -> tuple[dict, list[str]]:
    start, truth = start_and_truth()
    with tempfile.TemporaryDirectory() as folder:
        mine, theirs = Path(folder, "mine.xml"), Path(folder, "truth.xml")
        pid.export_mjcf(start, mine)
        pid.export_mjcf(truth, theirs)
        run, held_out = (record(start, theirs, seed) for seed in (1, 2))
        model, spent = by_physident(mine, run)
        results = {
            "as described": judged(start, truth, held_out),
            "physident": judged(model, truth, held_out) | {"s": spent},
        }
        for window, step in SETTINGS:
            model, spent, rounds = by_sysid(mine, run, window, step)
            name = f"mujoco.sysid, {window:g} s at a time, steps of {1e3 * step:g} ms"
            results[name] = judged(model, truth, held_out) | {"s": spent, "rounds": rounds}
    results["the truth"] = judged(truth, truth, held_out)
    head = f"{'28 free parameters, 30 s recorded':<50}{'armature':>9}{'damping':>9}{'friction':>9}{'mass':>7}{'centre':>8}{'tool':>7}{'processor':>11}"
    rows = [head, f"{'':<50}{'[%]':>9}{'[%]':>9}{'[%]':>9}{'[%]':>7}{'[mm]':>8}{'[mm]':>7}{'[s]':>11}"]
    for name, one in results.items():
        values = f"{one['armature']:9.2f}{one['damping']:9.2f}{one['frictionloss']:9.2f}{one['mass']:7.2f}{one['centre']:8.2f}"
        rows.append(f"{name:<50}{values}{one['tool']:7.2f}" + (f"{one['s']:11.1f}" if "s" in one else ""))
    return results, rows


def judged(model: pid.Model, truth: pid.Model, held_out: pid.Recording) -> dict[str, float]:
    """RMS errors [%] of the joints' parameters, of the last link's mass [%] and centre [mm], and of the tool [mm] half a
    second ahead in MuJoCo on a run that nobody fitted."""
    errors = {
        name: 100 * float(np.sqrt(np.mean((model.parameters(effect) / truth.parameters(effect) - 1) ** 2)))
        for name, effect in PER_JOINT.items()
    }
    last, true = model.theta[50:60], truth.theta[50:60]
    errors["mass"] = 100 * abs(float(last[0] / true[0] - 1))
    errors["centre"] = 1e3 * float(np.linalg.norm(last[1:4] / last[0] - true[1:4] / true[0]))
    errors["tool"] = 1e3 * replay(as_estimate(model, pid.Filter()), None, [held_out]).replay.before.tool
    return errors


def by_sysid(mine: Path, run: pid.Recording, window: float, step: float) -> tuple[pid.Model, float, int]:
    """The estimate of mujoco.sysid, from stretches of a length [s] that start at smoothed states of the recording."""
    logging.getLogger("absl").setLevel(logging.ERROR)
    begin = time.process_time()
    spec = with_sensors(mine)
    spec.option.timestep = step
    params = free_parameters(spec)
    size = measured_states(run).std(axis=0)

    def by_size(params, predicted, measured, model, return_all, **more):
        measured = sysid.TimeSeries(measured.times[1:], measured.data[1:], measured.signal_mapping)
        predicted = predicted.resample(measured.times)
        return (predicted.data - measured.data) / size, predicted, measured

    residual = sysid.build_residual_fn(models_sequences=[stretches(spec, run, window)], modify_residual=by_size)
    best, result = sysid.optimize(params, residual, max_iters=MOST_ROUNDS, output=io.StringIO())
    spent = time.process_time() - begin
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "found.xml").write_text(sysid.apply_param_modifiers_spec(best, spec).to_xml(), encoding="utf-8")
        robot = pid.load_robot(Path(folder, "found.xml"))
    joints = np.concatenate([robot.rotor_inertia, robot.damping, robot.dry_friction])
    return with_links(robot, robot.nominal, joints), spent, len(result.extras["objective"])


def measured_states(run: pid.Recording) -> Array:
    """Measured positions and velocities (N, 2 n)."""
    assert run.dq is not None
    return np.concatenate([run.q, run.dq], axis=1)


def with_sensors(path: Path) -> mujoco.MjSpec:
    """The arm's MJCF with the encoders of its joints as sensors."""
    spec = mujoco.MjSpec.from_file(str(path))
    for kind, sensor in (("q", mujoco.mjtSensor.mjSENS_JOINTPOS), ("v", mujoco.mjtSensor.mjSENS_JOINTVEL)):
        for joint in spec.joints:
            spec.add_sensor(
                name=f"{joint.name}_{kind}", type=sensor, objtype=mujoco.mjtObj.mjOBJ_JOINT, objname=joint.name
            )
    return spec


def free_parameters(spec: mujoco.MjSpec) -> sysid.ParameterDict:
    """Armature, damping and dry friction of every joint, from a tenth to ten times, and the inertia of the last body."""
    params = sysid.ParameterDict()
    for joint in spec.joints:
        for attribute in PER_JOINT:
            value = float(np.ravel(getattr(joint, attribute))[0])

            def write(one, parameter, name=joint.name, attribute=attribute) -> None:
                wanted = getattr(one.joint(name), attribute)
                if np.ndim(wanted):
                    wanted[0] = parameter.value[0]
                else:
                    setattr(one.joint(name), attribute, parameter.value[0])

            params.add(sysid.Parameter(f"{joint.name} {attribute}", value, value / 10, value * 10, modifier=write))
    last = spec.joints[-1].parent.name

    def write_body(one, parameter) -> None:
        sysid.apply_body_inertia(one, last, parameter)
        one.body(last).iquat = [1.0, 0.0, 0.0, 0.0]  # else MuJoCo 4.0.0 does not compile it

    wide = {"mass_bound_mult": np.array([0.1, 20.0]), "stretch_bound_mult": np.array([0.05, 20.0])}
    params.add(
        sysid.body_inertia_param(spec, spec.compile(), last, sysid.InertiaType.Pseudo, modifier=write_body, **wide)
    )
    return params


def stretches(spec: mujoco.MjSpec, run: pid.Recording, window: float) -> sysid.ModelSequences:
    """The recording in stretches of a length [s], with controls and sensors as measured and states as smoothed."""
    compiled = spec.compile()
    smooth = pid.prepare(run, pid.Filter())
    count, data = round(window * RATE), measured_states(run)
    states, controls, sensors = [], [], []
    for first in range(0, len(run.time) - count, count):
        rows = slice(first, first + count + 1)
        clock = run.time[rows] - run.time[first]
        states.append(sysid.create_initial_state(compiled, smooth.q[first], smooth.v[first]))
        controls.append(sysid.TimeSeries(clock, run.effort[rows]))
        sensors.append(sysid.TimeSeries.from_names(clock, data[rows], compiled))
    return sysid.ModelSequences("arm", spec, [f"{k}" for k in range(len(states))], states, controls, sensors)
