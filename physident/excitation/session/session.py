"""A session: several motions to record one after the other, and what they are expected to settle."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from physident.excitation.design import Design
from physident.excitation.motion.motion import Motion
from physident.excitation.motion.robot_programs import joint_trajectory_of, urscript_of
from physident.excitation.session.outlook_text import expected_rows
from physident.excitation.session.questions import Expectation
from physident.files import VERSION, write_json
from physident.outputs import together, write_with
from physident.robots.robot import Robot

SCHEMA = "physident.session/1"
FILE = "session.json"


@dataclass(frozen=True, eq=False)
class Leg:
    """One recording of a session: its ``name``, its motion and the ``speed`` as a share of the designed one.

    ``loaded``: the arm carries the load. ``holdout``: nothing is fitted to this recording. ``warm_up``: it is recorded for the record
    only. ``purpose`` says what it is for, ``settles`` which questions lose most without it.
    """

    name: str
    trajectory: Motion
    speed: float
    loaded: bool
    holdout: bool
    warm_up: bool = False
    purpose: str = ""
    settles: tuple[str, ...] = ()

    @property
    def role(self) -> str:
        """What the recording is used for."""
        return "holdout" if self.holdout else "warm-up" if self.warm_up else "fit"


@dataclass(frozen=True, kw_only=True, eq=False)
class Outlook:
    """What a planned session is expected to give.

    ``expectations`` answer its questions in their order; ``curve`` lists (minutes, expected number of questions settled) as the session
    proceeds. ``load`` [kg] is carried in loaded legs. ``noise`` says where the noise comes from, ``notes`` what could not be
    planned.
    """

    expectations: tuple[Expectation, ...]
    curve: tuple[tuple[float, float], ...]
    load: float | None
    noise: str
    notes: tuple[str, ...] = ()

    @property
    def settled(self) -> float:
        """Expected number of questions that the session settles."""
        return sum(one.settled for one in self.expectations)


@dataclass(frozen=True, eq=False)
class Session:
    """The ``legs`` of a session in the order to record them, and the ``designs`` behind them.

    ``outlook`` is what a session that was planned for open questions is expected to settle, None for any other.
    """

    legs: tuple[Leg, ...]
    designs: tuple[Design, ...]
    outlook: Outlook | None = None

    @property
    def duration(self) -> float:
        """Time in motion of all legs together [s]."""
        return sum(leg.trajectory.duration for leg in self.legs)

    def save(self, folder: str | Path) -> list[Path]:
        """Write each leg as NAME.json into an existing folder, and return the paths."""
        paths = [Path(folder) / f"{leg.name}.json" for leg in self.legs]
        for leg, path in zip(self.legs, paths, strict=True):
            leg.trajectory.save(path)
        return paths

    def paths(self, folder: str | Path) -> list[Path]:
        """The files that ``write`` makes."""
        endings = (".json", ".csv", ".script", ".yaml")
        return [*(Path(folder) / f"{leg.name}{end}" for leg in self.legs for end in endings), Path(folder) / FILE]

    def write(self, folder: str | Path, robot: Robot, rate: float, record: dict[str, Any] | None = None) -> list[Path]:
        """Write each leg as JSON, CSV, URScript and ROS 2 JointTrajectory at a rate [Hz], and session.json, all or none.

        ``record`` is kept in session.json beside what the session knows. Returns the paths; raises InputError for a rate or a folder that
        cannot be used.
        """
        with together():
            self.save(folder)
            for leg in self.legs:
                base = Path(folder) / leg.name
                leg.trajectory.write_csv(base.with_suffix(".csv"), rate)
                texts = {
                    ".script": urscript_of(leg.name, leg.trajectory, rate),
                    ".yaml": joint_trajectory_of(leg.trajectory, robot.joint_names, rate),
                }
                for ending, text in texts.items():
                    write_with(
                        base.with_suffix(ending), lambda path, text=text: path.write_text(text, encoding="utf-8")
                    )
            write_json(Path(folder) / FILE, {**self.as_dict(), "rate": rate, **(record or {})})
        return self.paths(folder)

    def as_dict(self) -> dict[str, Any]:
        """The session as JSON can hold it (schema physident.session/1), without its motions."""
        legs = [
            {"name": one.name, "role": one.role, "loaded": one.loaded, "duration": one.trajectory.duration,
             "purpose": one.purpose, "settles": list(one.settles)}
            for one in self.legs
        ]  # fmt: skip
        outlook = self.outlook
        known = {} if outlook is None else {
            "expectations": [one.as_dict() for one in outlook.expectations], "curve": [list(p) for p in outlook.curve],
            "load": outlook.load, "noise": outlook.noise, "notes": list(outlook.notes),
        }  # fmt: skip
        return {"schema": SCHEMA, "version": VERSION, "legs": legs, **known}

    def __repr__(self) -> str:
        rows = [
            f"Session: {len(self.legs)} recordings, {self.duration:.0f} s in motion",
            "  name                       speed     load   duration [s]   for",
        ]
        rows += [
            f"  {leg.name:<24} {100 * leg.speed:5.0f} %   {'yes' if leg.loaded else 'no':>6} {leg.trajectory.duration:14.1f}"
            f"   {leg.purpose or leg.role}"
            for leg in self.legs
        ]
        pooled = [leg for leg in self.legs if self.outlook is None or not leg.loaded]
        fitted = sum(leg.role == "fit" for leg in pooled)
        verdict = (
            f"{fitted} recordings to fit, each left out once, and {sum(leg.holdout for leg in self.legs)} held out"
        )
        if self.outlook is None:
            return "\n".join([*rows, f"verdict: {verdict}"])
        return "\n".join([*rows, *_expected(self.legs, self.outlook), f"verdict: {verdict}; {_sum(self.outlook)}"])


def _sum(outlook: Outlook) -> str:
    """What is expected of the whole session."""
    if not outlook.expectations:
        return "nothing is open that a motion within the limits settles"
    return f"{outlook.settled:.1f} of {len(outlook.expectations)} open questions are expected to be settled"


def _expected(legs: tuple[Leg, ...], outlook: Outlook) -> list[str]:
    """What each piece is for, and what is expected of each question."""
    rows = [f"  without {leg.name}, worse: {'; '.join(leg.settles)}" for leg in legs if leg.settles]
    if outlook.expectations:
        rows += [f"what it is expected to settle ({outlook.noise})", "  power        question"]
    rows += [f"  {power:<11}  {text}" for power, text in expected_rows(outlook.expectations)]
    rows += [f"  note: {note}" for note in outlook.notes]
    return rows
