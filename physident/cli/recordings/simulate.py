"""physident simulate: a recording of a simulated arm that follows a planned motion."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from physident.cli.app import app, busy, check_outputs, write_result
from physident.cli.options import JointsOption, JsonOption, LockOption, RobotOption, ToolOption, optional_robot
from physident.errors import InputError, did_you_mean

if TYPE_CHECKING:
    from physident.dynamics.model import Model
    from physident.recordings.recording import Recording
    from physident.robots.robot import Robot
    from physident.simulation.controllers import Controller
    from physident.simulation.simulate import Simulation

CONTROLLERS = ("pd", "computed-torque")


@app.command(short_help="Simulate an arm, and record it.")
def simulate(
    trajectory: Annotated[
        Path,
        typer.Option("--trajectory", metavar="FILE", help="The motion to follow (physident.trajectory/1)."),
    ],
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="The recording to write (.csv).")],
    model: Annotated[
        Path | None, typer.Option("--model", metavar="FILE", help="The arm: a model that identify wrote.")
    ] = None,
    robot: RobotOption = None,
    joints: JointsOption = None,
    lock: LockOption = None,
    tool: ToolOption = None,
    sensors: Annotated[
        Path | None, typer.Option("--sensors", metavar="FILE", help="Its sensors (physident.sensors/1).")
    ] = None,
    controller: Annotated[str, typer.Option("--controller", metavar="NAME", help="pd or computed-torque.")] = "pd",
    seed: Annotated[int, typer.Option("--seed", min=0, metavar="N", help="Seed of the sensors' noise.")] = 0,
    json_out: JsonOption = None,
) -> None:
    """Simulate an arm with all effects of its model while it follows a motion, and write what its sensors record."""
    from physident.excitation.motion.trajectory import load_trajectory
    from physident.outputs import together
    from physident.recordings.formats.csv import write_csv
    from physident.simulation.sensors import Sensors, load_sensors
    from physident.simulation.simulate import Simulation

    if out.suffix != ".csv":
        raise InputError(f"--out is {str(out)!r}, expected a file that ends in .csv")
    check_outputs([trajectory, model, robot, sensors], out, json_out)
    chosen = load_sensors(sensors) if sensors else Sensors()
    motion = load_trajectory(trajectory)
    simulation = Simulation(
        _arm(model, optional_robot(robot, joints, lock, tool)), motion, _controller(controller), chosen, seed=seed
    )
    with busy("simulating"):
        table = simulation.table()
    recording = simulation.recording(table)
    with together():
        write_csv(out, table)
        write_result(json_out, "simulation", _facts(simulation, recording, out) | {"controller": controller})
    typer.echo(f"{recording!r}\nwritten: {out}")


def _facts(simulation: Simulation, recording: Recording, out: Path) -> dict[str, Any]:
    """What was simulated, and the ranges of what was recorded, for JSON."""
    return {
        "recording": str(out),
        "robot": simulation.model.robot.name,
        "effects": [effect.as_dict() for effect in simulation.model.effects],
        "seed": simulation.seed,
        "joints": recording.n,
        "rows": len(recording.time),
        "bad_rows": len(recording.rejected),
        "duration_s": float(recording.duration),
        "effort_kind": recording.effort_kind,
        "position": [recording.q.min(axis=0).tolist(), recording.q.max(axis=0).tolist()],
        "effort": [recording.effort.min(axis=0).tolist(), recording.effort.max(axis=0).tolist()],
    }


def _arm(model: Path | None, robot: Robot | None) -> Model:
    from physident.dynamics.model import Model
    from physident.estimation.estimate_file import load_estimate

    if (model is None) == (robot is None):
        raise InputError("which arm? expected either --model (an identified model) or --robot (a description)")
    if robot is not None:
        return Model.nominal(robot, _simulated(robot))
    assert model is not None
    return load_estimate(model).model


def _simulated(robot: Robot) -> dict[str, None]:
    """Names of the effects of a simulated arm: the default ones, and those that its description states."""
    from physident.effects.catalogue import DEFAULT_EFFECTS, described_effects

    return dict.fromkeys((*DEFAULT_EFFECTS, *(effect.name for effect in described_effects(robot))))


def _controller(name: str) -> Controller | None:
    from physident.simulation.controllers import ComputedTorque

    if name not in CONTROLLERS:
        raise InputError(
            f"--controller is {name!r}, expected one of {', '.join(CONTROLLERS)}{did_you_mean(name, CONTROLLERS)}"
        )
    return ComputedTorque() if name == "computed-torque" else None
