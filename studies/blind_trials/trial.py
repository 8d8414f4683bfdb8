"""One blind trial: an arm, a question, and an effect - or two - that an oracle can see as well as the tier says."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import physident as pid
from physident.estimation.estimate import as_estimate
from physident.estimation.identify import prepare_all
from physident.identifiability.identifiability import Identifiability, measure_identifiability
from physident.identifiability.visibility import VISIBLE
from studies.blind_trials.arms import ARMS, CACHE, FILTER, Taken, identified, motion, nominal, take
from studies.blind_trials.cases import KINDS, QUESTIONS, TIERS, Hidden, Rng, draw
from studies.blind_trials.sizing import oracle, pilot, scale
from tests.plant import Arm, hide
from tests.plant.motions import Motion

Array = NDArray[np.float64]
TRIES = 3  # rounds of recording and scaling before another draw
VISIBLE_TIERS = ("weak", "middle", "strong")


@dataclass(frozen=True)
class Trial:
    """What was drawn: a trial's set and number, its arm and question, its ``tier`` ("invisible" where the identifiability
    table says so), what is hidden, the oracle's reduction [%] on the joint (from 1) that shows it most."""

    group: int
    number: int
    arm: int
    question: str
    tier: str
    hidden: tuple[Hidden, ...]
    reduction: float
    joint: int
    tag: str

    @staticmethod
    def load(path: Path) -> Trial:
        """Read one that was saved."""
        data: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        hidden = tuple(
            Hidden(h["effect"], tuple(h["joints"]), h["magnitude"], tuple((k, _tupled(v)) for k, v in h["shape"]))
            for h in data.pop("hidden")
        )
        return Trial(hidden=hidden, **data)


@dataclass(frozen=True, eq=False)
class Prepared:
    """A trial with its model and recordings: two to diagnose, changed and clean, and a changed one held out."""

    trial: Trial
    model: pid.Estimate | pid.Model
    changed: tuple[Taken, ...]
    clean: tuple[Taken, ...]


@dataclass(frozen=True, eq=False)
class Scene:
    """What all draws of one trial share: the arm, its model, the question and clean recordings of the motions."""

    group: int
    number: int
    index: int
    question: str
    arm: Arm
    model: pid.Estimate | pid.Model
    clean: tuple[Taken, ...]

    @staticmethod
    def of(group: int, number: int) -> Scene:
        """The scene of a trial's number in a set; every tenth asks what is missing, where most cannot be seen."""
        rng = np.random.default_rng([group, number, 105])
        index = int(rng.integers(ARMS))
        question = str(rng.choice(QUESTIONS, p=[0.45, 0.45, 0.1]))
        if tier_of(number, False) == "invisible":
            question = "missing"
        arm, estimate = identified(group, index)
        folder = CACHE / f"set{group}" / f"{number:04d}"
        clean = tuple(take(folder / f"clean{k}", arm, _seed(group, number, k), arm) for k in range(2))
        model = nominal(arm) if question == "nominal" else estimate
        return Scene(group, number, index, question, arm, model, clean)

    def changed(self, hidden: Sequence[Hidden], tag: str) -> tuple[Taken, ...]:
        """The same motions of the arm with effects hidden in it; a contact in the first recording alone."""
        folder = CACHE / f"set{self.group}" / f"{self.number:04d}"
        result = []
        for k in range(3):
            own = [h for h in hidden if k == 0 or h.effect != "contact"]
            truth = self.arm
            for h in own:
                size, shape = h.doses()
                truth = hide(truth, h.effect, h.joints, size, **shape)
            result.append(take(folder / f"{tag}_{k}", truth, _seed(self.group, self.number, k), self.arm))
        return tuple(result)

    @property
    def plans(self) -> tuple[Motion, ...]:
        """The three motions."""
        return tuple(motion(_seed(self.group, self.number, k)) for k in range(3))

    def visible(self, table: Identifiability, hidden: Hidden) -> bool:
        """Whether the identifiability table calls an effect visible."""
        asked = "refitted" if self.question == "missing" else "new"
        return hidden.effect == "contact" or table.share(hidden.effect, hidden.joints, asked) >= VISIBLE


def _seed(group: int, number: int, k: int) -> int:
    return 1_000_000 * group + 10 * number + k


def tier_of(number: int, pair: bool) -> str:
    """Tiers in turn; one single trial in ten is of a cell that cannot be seen."""
    return ("middle", "strong")[number % 2] if pair else (*VISIBLE_TIERS * 3, "invisible")[number % 10]


def prepare(group: int, number: int, pair: bool) -> Prepared:
    """The trial of a number in a set, drawn and recorded where it is not on disk yet."""
    scene = Scene.of(group, number)
    saved = CACHE / f"set{group}" / f"{number:04d}" / "trial.json"
    if saved.exists():
        trial = Trial.load(saved)
        return Prepared(trial, scene.model, scene.changed(trial.hidden, trial.tag), scene.clean)
    rng = np.random.default_rng([group, number, 107])
    tier = tier_of(number, pair)
    robot = pid.load_robot("ur5")
    signals = prepare_all(robot, [taken.recording for taken in scene.clean], FILTER)
    table = measure_identifiability(robot, signals, FILTER)
    for attempt in range(200):
        hidden = tuple(draw(name, rng) for name in _names(number, attempt, pair, rng))
        if any(scene.visible(table, h) == (tier == "invisible") for h in hidden):
            continue
        made = _made(scene, tier, hidden, attempt, rng)
        if made is not None:
            saved.write_text(json.dumps(asdict(made.trial)), encoding="utf-8")
            return made
    raise RuntimeError(f"trial {number} of set {group}: no draw of two hundred fits tier {tier}")


def _names(number: int, attempt: int, pair: bool, rng: Rng) -> list[str]:
    names = list(KINDS)
    first = names[(number + attempt) % len(names)]
    others = [name for name in names if name != first]
    return [first, str(rng.choice(others))] if pair else [first]


def _made(scene: Scene, tier: str, hidden: tuple[Hidden, ...], attempt: int, rng: Rng) -> Prepared | None:
    """The trial where each effect can be as strong as the tier asks; else None."""
    window = TIERS["strong" if tier == "invisible" else tier]
    target = float(rng.uniform(*window))
    noise = _noise(scene)
    sized = []
    for h in hidden:
        # a contact is in no other recording, and what cannot be seen is sized as if nothing were refitted
        asked = "different" if tier == "invisible" or h.effect == "contact" else scene.question
        plans = scene.plans[:1] if h.effect == "contact" else scene.plans
        size = pilot(h, scene.arm, plans, asked)
        factor = scale(target, size, noise)
        if tier == "invisible" and not size.any():
            factor = 0.5  # nothing shows it: any value will do
        if not factor < 1:
            return None
        sized.append(replace(h, magnitude=h.magnitude * factor))
    for again in range(TRIES):
        tag = f"changed{attempt}_{again}"
        changed = scene.changed(sized, tag)
        seen = oracle(scene.question, scene.model, changed, sized)
        trial = Trial(
            scene.group,
            scene.number,
            scene.index,
            scene.question,
            tier,
            tuple(sized),
            seen.percent,
            seen.joint + 1,
            tag,
        )
        if tier == "invisible" or len(sized) > 1 or window[0] <= seen.percent <= window[1]:
            return Prepared(trial, scene.model, changed, scene.clean)
        factor = scale(target, np.array([_strength(max(seen.percent, 0.3))]), np.ones(1))
        sized = [replace(h, magnitude=h.magnitude * factor) for h in sized]
        if abs(sized[0].magnitude) > abs(hidden[0].magnitude):
            return None
    return None


def _noise(scene: Scene) -> Array:
    """RMS (6,) [N m] of what the model leaves of clean recordings."""
    return pid.validate(as_estimate(scene.model, FILTER), [taken.recording for taken in scene.clean]).rms


def _strength(percent: float) -> float:
    """Size of an effect over the noise whose removal lowers the RMS by so much."""
    return float(np.sqrt(1 / (1 - percent / 100) ** 2 - 1))


def _tupled(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value
