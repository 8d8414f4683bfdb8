"""One trial: an arm, a question, and what is hidden, as strong as the tier says."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

import physident as pid
from studies.open_world.bench import AGAIN, ARMS, Bench, bench, healthy_seed, identified, plants, world_of
from studies.open_world.causes import ONCE, TIERS
from studies.open_world.sizing import Oracle, hidden_rms, residual_rms
from studies.open_world.taken import Taken
from studies.open_world.world import OutsideCause
from tests.truth import Disturbance, HiddenEffect

Array = NDArray[np.float64]
Kind = Literal["single", "pair", "outside"]
FROM = {"single": 0, "pair": 5000, "outside": 7000}  # numbers of each kind, so that no two share a motion
QUESTIONS = {"different": 0.55, "missing": 0.35, "nominal": 0.1}


@dataclass(frozen=True)
class Trial:
    """What was drawn and saved.

    ``kind``, ``number`` and arm of a trial of a ``group``; ``tier``; the ``hidden`` effects of the catalogue and of the
    plants; of a cause outside of it the ``outside`` name, its relative ``size`` and the number of the ``draw`` that gave
    its place. The oracle's ``reduction`` [%] on the ``joint`` (from 1) that shows it most; the ``tag`` of its recordings.
    """

    world: str
    group: int
    number: int
    kind: Kind
    arm: int
    question: str
    tier: str
    hidden: tuple[HiddenEffect, ...]
    reduction: float
    joint: int
    tag: str
    outside: str = ""
    size: float = 0.0
    draw: int = 0

    def save(self, path: Path) -> None:
        """Write it as JSON."""
        path.write_text(json.dumps(asdict(self)), encoding="utf-8")

    @staticmethod
    def load(path: Path) -> Trial:
        """Read one that was saved."""
        data: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        hidden = tuple(
            HiddenEffect(
                effect=h["effect"], joints=tuple(h["joints"]), size=h["size"],
                shape={key: tuple(v) if isinstance(v, list) else v for key, v in h["shape"].items()},
            )
            for h in data.pop("hidden")
        )  # fmt: skip
        return Trial(hidden=hidden, **data)


@dataclass(frozen=True, eq=False)
class Scene:
    """What all draws of one trial share: the arm, the question, its model and clean recordings of one motion or two."""

    kind: Kind
    number: int
    bench: Bench
    question: str
    model: pid.Estimate | pid.Model
    clean: tuple[Taken, ...]
    folder: Path
    noise: Array = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "noise", residual_rms(self.bench, self.model, self.clean))

    @property
    def refitted(self) -> bool:
        """Whether the model is fitted to the diagnosed recordings themselves."""
        return self.question == "missing"

    def seed(self, k: int) -> int:
        """Seed of the trial's motion k."""
        return 1_000_000 * self.bench.group + 10 * self.number + k

    def warmer(self, k: int) -> float:
        """How much warmer [K] recording k is."""
        return self.bench.world.conditions(self.seed(k))

    def twin(self) -> tuple[Taken, ...]:
        """Two recordings to diagnose of the arm in which nothing is hidden."""
        more = (_clean(self.bench, self.folder, self.seed(k), k) for k in range(len(self.clean), 2))
        return (*self.clean, *more)

    def record(
        self, tag: str, k: int, effects: tuple[HiddenEffect, ...], disturbances: tuple[Disturbance, ...]
    ) -> Taken:
        """Motion k of the arm with causes hidden in it; what happens once is in the first recording alone."""
        own = tuple(h for h in effects if k == 0 or h.effect not in ONCE)
        # the hidden torque is asked of the held-out recording, of what happens once, and of all that a model is fitted to
        known = self.refitted or k == 2 or any(h.effect in ONCE for h in own)
        along = _along(self.bench, k)
        return self.bench.record(
            self.folder / f"{tag}_{k}", self.seed(k), self.warmer(k), own, disturbances, known, along
        )

    def changed(
        self, tag: str, effects: tuple[HiddenEffect, ...], disturbances: tuple[Disturbance, ...]
    ) -> tuple[Taken, ...]:
        """Two recordings to diagnose and one held out."""
        return tuple(self.record(tag, k, effects, disturbances) for k in range(3))

    def oracle(self, tag: str, effects: tuple[HiddenEffect, ...], disturbances: tuple[Disturbance, ...]) -> Oracle:
        """The oracle's gain on the held-out recording, or on the first for what happens once."""
        if any(h.effect in ONCE for h in effects):
            taken = [self.record(tag, 0, effects, disturbances)]
            return Oracle.of(hidden_rms(self.bench, taken, False), self.noise)
        if self.refitted:
            return Oracle.of(hidden_rms(self.bench, self.changed(tag, effects, disturbances), True), self.noise)
        return Oracle.of(hidden_rms(self.bench, [self.record(tag, 2, effects, disturbances)], False), self.noise)


def open_scene(world: str, group: int, kind: Kind, number: int) -> Scene:
    """The scene of a trial's number; raises PhysidentError where physident refuses the healthy recordings."""
    rng = np.random.default_rng([group, FROM[kind] + number, 105])
    index = int(rng.integers(ARMS))
    question = str(rng.choice(list(QUESTIONS), p=list(QUESTIONS.values())))
    question = (
        "different" if world == AGAIN else question
    )  # there is nothing to repeat without a model's own recordings
    if kind == "outside":
        index = _able(world, group, index, number)
    return scene_of(world, group, kind, number, index, question)


def scene_of(world: str, group: int, kind: Kind, number: int, index: int, question: str) -> Scene:
    """The scene of an arm and a question."""
    one = bench(world, group, index)
    own = FROM[kind] + number
    folder = one.folder.parent / f"{own:04d}"
    seed = 1_000_000 * group + 10 * own
    healthy = 2 if kind == "single" else 1  # a twin to diagnose, or just enough to see what the model leaves
    clean = tuple(_clean(one, folder, seed + k, k) for k in range(healthy))
    if question == "missing":
        model: pid.Estimate | pid.Model = pid.identify(one.robot, [t.recording for t in clean], filter=one.filter)
    else:
        model = one.nominal() if question == "nominal" else identified(world, group, index)
    return Scene(kind, own, one, question, model, clean, folder)


def _clean(one: Bench, folder: Path, seed: int, k: int) -> Taken:
    """Recording k of an arm in which nothing is hidden."""
    return one.record(folder / f"clean_{k}", seed, one.world.conditions(seed), along=_along(one, k))


def _along(one: Bench, k: int) -> int | None:
    """The seed of the motion that recording k repeats, None where it has its own: the held-out one always does."""
    return healthy_seed(one.group, one.index, k) if one.name == AGAIN and k < 2 else None


def outside_of(scene: Scene, name: str, draw: int) -> OutsideCause:
    """The cause outside of the catalogue of a trial's draw."""
    rng = np.random.default_rng([scene.bench.group, scene.number, draw, 109])
    return scene.bench.world.outside(name, scene.bench.arm, rng)


def parts(scene: Scene, trial: Trial) -> tuple[tuple[HiddenEffect, ...], tuple[Disturbance, ...]]:
    """All that is hidden in a trial's arm."""
    if not trial.outside:
        return trial.hidden, ()
    return outside_of(scene, trial.outside, trial.draw).make(trial.size)


def tier_of(kind: Kind, number: int) -> str:
    """Tiers in turn; those of pairs and of outside causes can be seen."""
    names = tuple(TIERS) if kind == "single" else ("middle", "strong")
    return names[number % len(names)]


def _able(world: str, group: int, index: int, number: int) -> int:
    """An arm before a plant that can do the outside cause of a trial's number: this one, or its neighbour."""
    known = world_of(world)
    name = known.OUTSIDE[number % len(known.OUTSIDE)]
    for other in (index, index ^ 1):
        arm = known.arm(10_000 * group + other)
        effects, _ = known.outside(name, arm, np.random.default_rng(0)).make(0.1)
        if all(h.effect in plants()[other % 2].effects for h in effects):
            return other
    return index
