"""One trial from its seed to its row: recorded, diagnosed, scored, and its clean twin beside it."""

from __future__ import annotations

import time
from dataclasses import asdict
from typing import Any

import physident as pid
from studies.open_world.drawing import drawn
from studies.open_world.scoring import score, score_outside, score_twin
from studies.open_world.taken import SPENT, Taken
from studies.open_world.trial import FROM, Kind, Scene, Trial, open_scene, outside_of, parts

Job = tuple[str, int, Kind, int]


def judge(job: Job) -> dict[str, Any]:
    """One trial; a refusal by physident and any other error are rows like others."""
    world, group, kind, number = job
    row: dict[str, Any] = {"world": world, "set": group, "kind": kind, "number": FROM[kind] + number}
    clock = Clock()
    try:
        scene = open_scene(world, group, kind, number)
        row["strata"] = strata(scene)
        clock.lap("preparation")
        trial = drawn(scene)
        changed = scene.changed(trial.tag, *parts(scene, trial))
        row |= asdict(trial) | {"strata": row["strata"] | {"tier": trial.tier}}
        clock.lap("preparation")
        row |= _scored(scene, trial, changed, clock)
    except pid.PhysidentError as refusal:
        row["refused"] = f"{type(refusal).__name__}: {refusal}"
    except Exception as failure:  # a crash of whatever kind must not end the run, nor vanish from the table
        row["failed"] = f"{type(failure).__name__}: {failure}"
    return row | {"seconds": clock.spent()}


class Clock:
    """Processor time by stage; what simulating took is a stage of its own."""

    def __init__(self) -> None:
        self.laps = {"preparation": 0.0, "identification": 0.0, "diagnosis": 0.0, "scoring": 0.0}
        self.last, self.simulated = time.process_time(), SPENT["simulation"]

    def lap(self, stage: str) -> None:
        """Book the time since the last lap on a stage."""
        now = time.process_time()
        self.laps[stage] += now - self.last
        self.last = now

    def spent(self) -> dict[str, float]:
        """Seconds by stage."""
        simulation = SPENT["simulation"] - self.simulated
        return {**self.laps, "preparation": self.laps["preparation"] - simulation, "simulation": simulation}


def _scored(scene: Scene, trial: Trial, changed: tuple[Taken, ...], clock: Clock) -> dict[str, Any]:
    """Scores of the changed recordings and, of a single trial, of their clean twin."""
    found = diagnosed(scene, changed, clock)
    if trial.outside:
        cause = outside_of(scene, trial.outside, trial.draw)
        told = score_outside(scene, trial, cause, changed, found, lambda: diagnosed(scene, scene.twin(), clock))
        scored = {"outside_score": asdict(told), "variable": cause.variable, "where": list(cause.joints)}
    else:
        scored = {"score": asdict(score(scene, trial, changed, found))}
    clock.lap("scoring")
    if trial.kind == "single":
        scored["twin"] = asdict(score_twin(scene, diagnosed(scene, scene.twin(), clock)))
        clock.lap("scoring")
    return scored


def diagnosed(scene: Scene, taken: tuple[Taken, ...], clock: Clock) -> pid.Diagnosis:
    """The diagnosis of two recordings."""
    runs = [t.recording for t in taken[:2]]
    model = scene.model
    if scene.refitted:
        model = pid.identify(scene.bench.robot, runs, filter=scene.bench.filter)
        clock.lap("identification")
    found = pid.diagnose_motion(model, runs, filter=scene.bench.filter if isinstance(model, pid.Model) else None)
    clock.lap("diagnosis")
    return found


def strata(scene: Scene) -> dict[str, Any]:
    """What was drawn, by which the figures are split."""
    one = scene.bench
    warm = one.arm.friction.per_degree.any() and not scene.refitted
    return {
        "friction": one.arm.friction.kind,
        "arm": one.arm.name,
        "motion": scene.clean[0].motion,
        "sensor": f"{one.sensors.kind} velocity",
        "background": sorted({type(b).__name__ for b in one.arm.background}),
        "plant": one.plant.name,
        "question": scene.question,
        "temperature": "friction fell" if warm else "as before",
    }


def line(row: dict[str, Any]) -> str:
    """One trial in one line."""
    head = f"{row['kind']} {row['number']}"
    if "refused" in row or "failed" in row:
        return f"{head} REFUSED or FAILED: {row.get('refused') or row.get('failed')}"
    s = row.get("score") or row["outside_score"]
    truth = "; ".join(f"{h['effect']} {','.join(map(str, h['joints']))} {h['size']:.3g}" for h in row["hidden"])
    hidden = f"{row['outside']} {row['where']} {row['size']:.2g}" if row["outside"] else truth
    drawn_from = " ".join(
        str(row["strata"][name]) for name in ("arm", "friction", "motion", "sensor", "plant", "question")
    )
    verdict = ("alone" if s["alone"] else "class" if s["first"] else "MISSED") if "score" in row else (
        "misnamed" if s["wrong"] else "silent" if s["silent"] else "described")  # fmt: skip
    more = f" {s['others']} false, {s['own']} own, error {s['error'] and round(s['error'])} %" if "score" in row else ""
    twin = f" | TWIN {row['twin']['told']}" if row.get("twin", {}).get("told", "nothing") != "nothing" else ""
    seconds = " ".join(f"{value:.1f}" for value in row["seconds"].values())
    return f"[{drawn_from}] {head} {row['tier']} {row['reduction']:.1f} % on {row['joint']} {hidden}: {s['told']} | {verdict}{more}{twin} ({seconds} s)"
