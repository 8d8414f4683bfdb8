"""The first session of an arm: what is open before anything was recorded, and the noise that is assumed."""

from __future__ import annotations

import numpy as np

from physident.dynamics.model import Model
from physident.effects.catalogue import CATALOGUE
from physident.effects.classification import Detection, Scope
from physident.effects.effect import Effect
from physident.estimation.estimate import Estimate
from physident.excitation.detectability import Noise
from physident.excitation.motion.trajectory import random_trajectory
from physident.excitation.session.questions import OpenQuestion
from physident.recordings.signals import Filter

SHARE = 0.05  # of a joint's torque: what a good model of a real arm leaves
MEMORY = 1.0  # s: the residual of a real arm is correlated over seconds
MOTIONS = 3  # random ones, along which the size of the torque is taken


def first_questions(model: Model) -> tuple[OpenQuestion, ...]:
    """How large each effect of the model is besides its links, and whether each other effect of the catalogue is there, at each
    of its places. A change of a link or of all friction is part of the model, which is identified."""
    found = []
    for cls in CATALOGUE.values():
        if cls.detection is not Detection.BY_PLACE or not cls.can_be_wrong(model.robot) or cls.within_model:
            continue
        owned = {j + 1 for e in model.effects if e.name == cls.name for j in e.active(model.robot)}
        for joints in cls.places(model.robot):
            kind = "parameter" if joints and set(joints) <= owned else "unseen"
            found.append(OpenQuestion(kind=kind, effect=effect_at(model, cls.name, joints)))
    return tuple(found)


def effect_at(model: Model, name: str, joints: tuple[int, ...]) -> Effect:
    """An effect on some joints (from 1; empty: the whole arm) as the model has it, or in the middle of its shapes."""
    cls = CATALOGUE[name]
    for effect in model.effects:
        if effect.name != name or (joints and not {j - 1 for j in joints} <= set(effect.active(model.robot))):
            continue
        if cls.scope is Scope.WHOLE_ARM:
            return effect
        if cls.scope is Scope.NEIGHBOURS and effect.joints != joints:
            continue
        fields = (*(shape.field for shape in cls.shape_parameters), *cls.settings_by_joint)
        index = [effect.active(model.robot).index(j - 1) for j in joints]
        given = {f: v for f in fields if isinstance(v := getattr(effect, f), tuple)}
        chosen = {f: tuple(v[i] for i in index) if len(v) > 1 else v for f, v in given.items()}
        return type(effect)(joints=joints, **chosen)
    beside = cls.options_beside(model.robot, model.effect_parameters())
    return beside[0] if beside else cls.at_grid_middle(model.robot, joints or None)


def noise_of(estimate: Estimate) -> tuple[Noise, str]:
    """The noise of an estimate's residual, and where it comes from in words."""
    used = max(1, sum(one.used for one in estimate.sources))
    sigma = np.maximum(estimate.sigma, 1e-9 * max(float(estimate.sigma.max()), 1e-12))
    worth = np.maximum(estimate.effective_samples / used, 1e-3)
    return Noise(sigma=sigma, worth=worth, filter=estimate.filter), "noise: the model's residual on its own recordings"


def assumed_noise(model: Model, noise: float | None) -> tuple[Noise, str]:
    """Noise of ``noise`` [N m|N] on every joint, or without it a share of each joint's torque along random motions."""
    n = model.robot.n
    worth = np.full(n, 1 / MEMORY)
    if noise is not None:
        return Noise(
            sigma=np.full(n, noise), worth=worth, filter=Filter()
        ), f"noise: {noise:g} N m after the filter, as given"
    squares = []
    for seed in range(MOTIONS):
        motion = random_trajectory(model.robot, seed)
        squares.append((model.torque(motion.evenly(200)) ** 2).mean(axis=0))
    rms = np.sqrt(np.mean(squares, axis=0))
    sigma = SHARE * np.maximum(rms, 1e-2 * max(float(rms.max()), 1e-9))
    words = f"noise: assumed to be {100 * SHARE:.0f} % of each joint's torque and to last {MEMORY:g} s, because nothing was recorded yet"
    return Noise(sigma=sigma, worth=worth, filter=Filter()), words
