"""The parts of a diagnosis: findings with their numbers, errors per joint, placebos, and effects that cannot be seen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
UnseenReason = Literal[
    "shows no torque",
    "inside what the baseline may take up",
    "of a joint that does not move",
    "of a joint that moves too little",
]
Role = Literal["diagnosed", "holdout", "before"]  # before: what a change was held against, where it was given
Grade = Literal["cause", "contribution", "hint"]
OPEN = 100.0  # times a shape: beyond, not even its order of magnitude is known
SEARCHES = 20  # on halves: a share is then known to a tenth
Verdict = Literal["explained", "partly_explained", "nothing_missing", "unexplained"]


@dataclass(frozen=True, kw_only=True)
class ParameterValue:
    """A parameter of a finding: its ``value`` in the extended model, with its standard error and 95 % interval, and the ``change`` that was
    found, with the interval of that, in ``unit``; ``at_end`` where a shape lies at an end of the range that is searched.

    Before the change the value was ``value - change``. The model may have had another: what these recordings share out otherwise
    between parameters that make nearly the same torque has not changed.
    """

    name: str
    joint: int
    value: float
    change: float
    std: float
    interval95: tuple[float, float]
    change_interval95: tuple[float, float]
    unit: str
    at_end: bool = False

    @property
    def is_open(self) -> bool:
        """Whether a shape, which is known by its logarithm, may be a hundred times as large or as small: then it is not known."""
        low, high = self.interval95
        return low > 0 and high > OPEN * self.value


@dataclass(frozen=True, kw_only=True)
class Reduction:
    """RMS [N m|N] over all joints, weighted by noise and by how much of a finding shows on each, without and with it on rows that were left out, and its
    reduction [%] with a 95 % interval."""

    rms_before: float
    rms_after: float
    reduction_percent: float
    interval95: tuple[float, float]


@dataclass(frozen=True)
class Rival:
    """An effect that could stand in a finding's place as far as these recordings can tell; ``inseparable`` where it makes nearly
    the same torque on any motion within their ranges."""

    effect: str
    joints: tuple[int, ...]
    inseparable: bool = False


@dataclass(frozen=True, kw_only=True)
class CurveBand:
    """A learned curve of one joint: ``torque`` [N m|N] over the ``quantity`` at ``x``, in its ``unit``, with the ends ``low`` and
    ``high`` of its 95 % band."""

    joint: int
    quantity: str
    unit: str
    x: tuple[float, ...]
    torque: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class Finding:
    """A named cause: an effect on some joints (from 1; empty: the whole arm), with its values and its gain on left-out rows.

    ``rivals`` could stand in its place, ``advice`` says what would separate them, and where a curve was not judged. A contact has ``intervals`` (start, end)
    [s] and the hash of its ``recording``. ``evidence`` is the left-out gain in units of the noise, ``threshold`` what it had to exceed (None where
    that is not known), both summed over the joints.

    A "cause" takes more than it leaves: ``takes_percent`` of the squared left-out error where it shows vanishes with it, all else
    refitted, and ``leaves_percent`` of it remains unexplained in the end. A "contribution" takes less, or its values are vague.
    A "hint" has ``doubts``: it made the error of a holdout worse, its sign changes between recordings,
    it is not stable, or the left-out rows are predicted no worse without it.
    ``stability`` is the share of SEARCHES searches on halves of the recordings that find it or a rival; None for a contact, and
    where recordings are too short to be halved. ``confounder`` says what else differs between before and after, and could be
    what the finding shows. ``in_words`` says what its values mean, where numbers with units do not; ``curves`` are those of a learned
    effect. ``no_cause`` says why a contribution is no cause, although it takes more than it leaves. Of what is no hint, a curve
    is not ``handed_on`` in the extended model where a holdout beyond its range is predicted worse with it. What is no proven change is
    ``mostly_new`` where the recordings from before show less than half of it.
    """

    effect: str
    joints: tuple[int, ...]
    parameters: tuple[ParameterValue, ...]
    gain: Reduction
    rivals: tuple[Rival, ...]
    intervals: tuple[tuple[float, float], ...]
    advice: str
    evidence: float
    threshold: float | None = None
    recording: str = ""
    grade: Grade = "cause"
    takes_percent: float | None = None
    leaves_percent: float | None = None
    in_words: str = ""
    stability: float | None = None
    doubts: tuple[str, ...] = ()
    confounder: str = ""
    curves: tuple[CurveBand, ...] = ()
    no_cause: str = ""
    handed_on: bool = True
    mostly_new: bool = False

    @property
    def by_joint(self) -> bool:
        """Whether its values are those of several joints."""
        return len({value.joint for value in self.parameters}) > 1


@dataclass(frozen=True, eq=False)
class JointErrors:
    """Error of one model over all rows: ``rms`` (n,) [N m|N] and ``relative`` (n,) [%], with the friction of joints at rest at
    the value inside its band that serves the model best."""

    rms: Array
    relative: Array

    def as_dict(self) -> dict[str, Any]:
        """The error as JSON can hold it."""
        return {"rms": self.rms.tolist(), "relative_percent_all": self.relative.tolist()}


@dataclass(frozen=True)
class Placebo:
    """A column that cannot be a cause: its evidence on left-out rows, and the threshold."""

    name: str
    joint: int
    gain: float
    threshold: float

    @property
    def passed(self) -> bool:
        """Whether it exceeds the threshold, which it must not."""
        return self.gain > self.threshold


@dataclass(frozen=True)
class Unseen:
    """An effect on some joints that these recordings cannot show, and why."""

    effect: str
    joints: tuple[int, ...]
    reason: UnseenReason


@dataclass(frozen=True)
class UsedRecording:
    """A recording and its role in the diagnosis; ``repeats`` is the recording of the model whose motion it repeats, so that both were
    compared row by row."""

    path: str
    sha256: str
    role: Role
    repeats: str | None = None
