"""What is hidden in a trial: drawn, and scaled until an oracle gains what the tier says."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from studies.open_world.bench import DEFAULT, DURATION
from studies.open_world.causes import KINDS, ONCE, TIERS, Ground, draw, scaled
from studies.open_world.scale import scale_of
from studies.open_world.sizing import Oracle, pilot, strength
from studies.open_world.taken import Unsound
from studies.open_world.trial import FROM, Scene, Trial, outside_of, tier_of
from studies.open_world.world import OutsideCause
from tests.truth import HiddenEffect

Rng = np.random.Generator
TRIES = 4  # rounds of recording and scaling before another draw
DRAWS = 60
LEAST_LEFT = 0.03  # share of a torque that must be left where the model is fitted along: less has another name as well


def drawn(scene: Scene) -> Trial:
    """The trial of a scene, from disk where it was drawn before."""
    saved = scene.folder / "trial.json"
    if saved.exists():
        return Trial.load(saved)
    made = _outside(scene) if scene.kind == "outside" else _catalogue(scene)
    made.save(saved)
    return made


def _catalogue(scene: Scene) -> Trial:
    """One effect of the catalogue or two; names take turns over the trials."""
    rng = np.random.default_rng([scene.bench.group, scene.number, 107])
    ground = Ground(scene.bench.arm, scale_of(scene.bench.arm), DURATION)
    names = [name for name in KINDS if name in scene.bench.plant.effects]
    if scene.refitted:  # of what is fitted along, nothing is missing
        names = [name for name in names if name not in DEFAULT]
    tier = tier_of(scene.kind, scene.number - FROM[scene.kind])
    for attempt in range(DRAWS):
        first = names[(scene.number + attempt) % len(names)]
        other = str(rng.choice([name for name in names if name != first]))
        target = float(rng.uniform(*TIERS[tier]))
        guesses = [
            _guess(scene, name, ground, target, rng) for name in ((first, other) if scene.kind == "pair" else (first,))
        ]
        hidden = tuple(g for g in guesses if g is not None)
        if len(hidden) < len(guesses):
            continue
        try:
            trial = _recorded(scene, tier, hidden, target, attempt)
        except Unsound:
            continue
        if trial is not None:
            return trial
    raise RuntimeError(f"trial {scene.number} of set {scene.bench.group}: no draw of {DRAWS} fits tier {tier}")


def _guess(scene: Scene, name: str, ground: Ground, target: float, rng: Rng) -> HiddenEffect | None:
    """An effect scaled by its torque along the plan; None where this arm cannot have so much of it, or it has another name."""
    hidden = draw(name, ground, rng)
    if hidden is None:
        return None
    once = name in ONCE
    k = 0 if once else 2
    refitted = scene.refitted and not once
    seen = pilot(scene.bench, hidden, scene.seed(k), scene.warmer(k), refitted)
    if refitted:
        whole = pilot(scene.bench, hidden, scene.seed(k), scene.warmer(k), False)
        joint = int(np.argmax(seen / scene.noise))
        if seen[joint] < LEAST_LEFT * whole[joint]:
            return None
    factor = strength(target) / max(float(np.max(seen / scene.noise)), 1e-9)
    return scaled(hidden, factor) if factor < 1 else None


def _recorded(scene: Scene, tier: str, hidden: tuple[HiddenEffect, ...], target: float, attempt: int) -> Trial | None:
    """The trial once its recordings are of the tier; a pair is taken as it was guessed."""
    largest = abs(hidden[0].size)
    for again in range(TRIES):
        tag = f"changed{attempt}_{again}"
        seen = scene.oracle(tag, hidden, ())
        if len(hidden) > 1 or _within(tier, seen):
            scene.changed(tag, hidden, ())
            return _trial(scene, tier, hidden, seen, tag)
        _discard(scene.folder, tag)
        factor = float(np.clip(strength(target) / strength(max(seen.percent, 0.05)), 0.1, 5.0))
        hidden = tuple(scaled(h, factor) for h in hidden)
        if abs(hidden[0].size) > 8 * largest:
            return None
    return None


def _outside(scene: Scene) -> Trial:
    """A cause outside of the catalogue, recorded and scaled until it is of the tier."""
    names = scene.bench.world.OUTSIDE
    number = scene.number - FROM["outside"]
    name = names[number % len(names)]
    tier = tier_of("outside", number // len(names))
    rng = np.random.default_rng([scene.bench.group, scene.number, 111])
    best: Trial | None = None
    for attempt in range(DRAWS // 4):
        cause = outside_of(scene, name, attempt)
        trial, fits = _scaled_outside(scene, cause, tier, float(rng.uniform(*TIERS[tier])), attempt)
        if trial is not None and not _whole(scene, cause, trial):
            continue
        if trial is not None and (best is None or trial.reduction > best.reduction):
            best = trial
        if fits and trial is not None:
            return trial
    if best is None:
        raise RuntimeError(f"trial {scene.number} of set {scene.bench.group}: no draw of {name} can be simulated")
    return replace(best, tier="weaker")


def _scaled_outside(
    scene: Scene, cause: OutsideCause, tier: str, target: float, attempt: int
) -> tuple[Trial | None, bool]:
    """The trial of the last size that could be simulated, and whether it is of the tier."""
    size, last = 0.3 * cause.most, None
    for again in range(TRIES):
        tag = f"outside{attempt}_{again}"
        try:
            seen = scene.oracle(tag, *cause.make(size))
        except Unsound:
            _discard(scene.folder, tag)
            size *= 0.4
            continue
        if last is not None:
            _discard(scene.folder, last.tag)
        last = _trial(scene, tier, cause.make(size)[0], seen, tag)
        last = replace(last, outside=cause.kind, size=size, draw=attempt)
        if _within(tier, seen):
            return last, True
        if size >= cause.most and seen.percent < target:
            return last, False
        factor = float(np.clip(strength(target) / strength(max(seen.percent, 0.05)), 0.1, 6.0))
        size = min(size * factor, cause.most)
    return last, False


def _whole(scene: Scene, cause: OutsideCause, trial: Trial) -> bool:
    """Whether all recordings of a trial can be simulated."""
    try:
        scene.changed(trial.tag, *cause.make(trial.size))
    except Unsound:
        return False
    return True


def _within(tier: str, seen: Oracle) -> bool:
    low, high = TIERS[tier]
    return low <= seen.percent <= high


def _trial(scene: Scene, tier: str, hidden: tuple[HiddenEffect, ...], seen: Oracle, tag: str) -> Trial:
    one = scene.bench
    return Trial(
        one.name, one.group, scene.number, scene.kind, one.index, scene.question, tier, hidden, seen.percent,
        seen.joint + 1, tag,
    )  # fmt: skip


def _discard(folder: Path, tag: str) -> None:
    """Remove recordings of a size that was not taken."""
    for path in folder.glob(f"{tag}_*"):
        path.unlink(missing_ok=True)
