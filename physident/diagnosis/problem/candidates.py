"""Candidates: every effect of the catalogue at every place on the arm, with every value of its shape; and placebos."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.dynamics.regressor import JointRows, Regressor
from physident.effects.catalogue import CATALOGUE
from physident.effects.classification import Detection
from physident.effects.contact import Contact
from physident.effects.effect import Effect
from physident.effects.learned.curve import LearnedCurve
from physident.effects.scales.shared_scale import SharedScale
from physident.large_arrays import empty, steps
from physident.recordings.signals import Signals

Array = NDArray[np.float64]
PLACEBOS = ("placebo_reversed", "placebo_random")
STIFF = 1e-4  # 1/N^2: a force of 100 N is one standard deviation, which keeps a singular pose from inventing more


def prior_precision(effect: Effect | None, count: int) -> Array:
    """Prior precision of the ``count`` values of a candidate's effect: none, but for the force of a contact, a learned curve of one joint,
    and what joints have of their own where all are scaled."""
    if isinstance(effect, LearnedCurve) and effect.amplitude is not None:
        return effect.prior_sizes_of_one() ** -2
    if isinstance(effect, SharedScale) and effect.uneven_percent is not None:
        return np.full(count, effect.uneven_percent**-2)
    return np.full(count, STIFF if isinstance(effect, Contact) else 0.0)


@dataclass(frozen=True)
class Option:
    """One concrete effect with its shape parameter set, and the indices of its columns in the regressor.

    ``precision`` (k,) is that of a prior of their values around zero, by default the effect's own.
    """

    effect: Effect | None
    columns: tuple[int, ...]
    precision: tuple[float, ...] | None = None

    @property
    def prior(self) -> Array:
        """Prior precision (k,) of the values."""
        return prior_precision(self.effect, len(self.columns)) if self.precision is None else np.array(self.precision)


@dataclass(frozen=True)
class Candidate:
    """An effect on some joints (from 1; empty: the whole arm) with an option for each shape of its grid."""

    name: str
    joints: tuple[int, ...]
    options: tuple[Option, ...]

    @property
    def placebo(self) -> bool:
        """Whether it is a column that cannot be a cause."""
        return False

    @property
    def size(self) -> int:
        """How many numbers it may choose: columns, and one for a shape that is searched."""
        return len(self.options[0].columns) + (len(self.options) > 1)

    @property
    def key(self) -> tuple[str, tuple[int, ...]]:
        """Name and joints, which no two candidates share."""
        return self.name, self.joints


class PlaceboCandidate(Candidate):
    """A column that no arm can have, scored like every candidate as a check of the thresholds."""

    @property
    def placebo(self) -> bool:
        """Whether it is a column that cannot be a cause."""
        return True


@dataclass(frozen=True)
class AcceptedEffect:
    """A candidate that was accepted, and its concrete effect with the shape it was found to have."""

    candidate: Candidate
    effect: Effect


def candidate_effects(model: Model, signals: Sequence[Signals]) -> list[tuple[str, tuple[int, ...], list[Effect]]]:
    """Name, joints and concrete effects of every candidate but contact, for a model and the signals to explain; no effects where the
    signals cannot show the candidate for what it is."""
    found, parameters = [], model.effect_parameters()
    for name, cls in CATALOGUE.items():
        if cls.detection is not Detection.BY_PLACE or not cls.can_be_wrong(model.robot):
            continue
        if cls.needs_torque_sensor and any(one.from_currents for one in signals):
            continue
        beside = cls.options_beside(model.robot, parameters)
        for joints in cls.places(model.robot):
            present = _in_model(model, name, joints)
            options = cls.search_options(model.robot, joints, signals) if beside is None else beside
            options = options if present is None else [present]
            found.append((name, joints, options))
    return found


def _in_model(model: Model, name: str, joints: tuple[int, ...]) -> Effect | None:
    """The effect of that name in the model, on these joints alone: the candidate is then a change of its value."""
    for effect in model.effects:
        if effect.name != name:
            continue
        if len(joints) != 1:
            if effect.joints in (None, joints):
                return effect if not joints else replace(effect, joints=joints)
            continue
        active = effect.active(model.robot)
        if joints[0] - 1 not in active:
            continue
        index = active.index(joints[0] - 1)
        fields = (*(shape.field for shape in effect.shape_parameters), *effect.settings_by_joint)
        given: dict[str, tuple[float, ...]] = {f: v for f in fields if isinstance(v := getattr(effect, f), tuple)}
        shapes = {field: values[index : index + 1] if len(values) > 1 else values for field, values in given.items()}
        return replace(effect, joints=joints, **shapes)
    return None


def with_placebos(regressor: Regressor, seed: int) -> tuple[Regressor, tuple[Candidate, ...]]:
    """The regressor in memory, with two columns more for each joint that no arm can have: the joint's dry friction played
    backwards, and smooth noise with the spectrum of the joint's torque."""
    from physident.diagnosis.statistics.surrogates import phase_randomised

    p, n = len(regressor.columns), len(regressor.joints)
    backward = played_backwards(regressor.segment)
    noise = phase_randomised(regressor.torque, regressor.segment, 1, seed)[:, :, 0]
    joints, placebos = [], []
    for j, rows in enumerate(regressor.joints):
        dry = [k for k, c in enumerate(rows.columns) if regressor.columns[c].name == f"coulomb_friction_{j + 1}"]
        places = (p + 2 * j, p + 2 * j + 1)
        values = empty((len(rows.columns) + 2, len(noise))).T
        for some in steps(len(noise)):
            values[some, :-2] = rows.some(some)
        values[:, -2] = values[backward, dry[-1]]
        values[:, -1] = noise[:, j]
        values[~regressor.counted[:, j], -2:] = 0.0
        joints.append(JointRows(np.append(rows.columns, places), values))
        placebos += [
            PlaceboCandidate(name, (j + 1,), (Option(None, (at,)),)) for name, at in zip(PLACEBOS, places, strict=True)
        ]
    dummy = regressor.columns[-1]
    return replace(regressor, columns=regressor.columns + (dummy,) * (2 * n), joints=tuple(joints)), tuple(placebos)


def played_backwards(segment: NDArray[np.intp]) -> NDArray[np.intp]:
    """The rows (M,) in order, each contiguous segment (label (M,)) backwards; segments are consecutive."""
    edges = np.flatnonzero(np.diff(segment)) + 1
    return np.concatenate([part[::-1] for part in np.split(np.arange(len(segment)), edges)])


def laid_out(model: Model, signals: Sequence[Signals]) -> tuple[tuple[Candidate, ...], list[Effect]]:
    """All candidates with the places of their columns, and the effects, the model's first, in the order of the columns."""
    effects: list[Effect] = list(model.effects)
    at = len(model.columns)
    candidates = []
    for name, joints, shaped in candidate_effects(model, signals):
        if not shaped:
            continue
        options = []
        for effect in shaped:
            count = len(effect.columns(model.robot))
            options.append(Option(effect, tuple(range(at, at + count))))
            effects.append(effect)
            at += count
        candidates.append(Candidate(name, joints, tuple(options)))
    return tuple(candidates), effects
