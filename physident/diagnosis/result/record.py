"""The record of a diagnosis: everything that its file, its text, its report and its session show."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.question import Question
from physident.diagnosis.remainder.in_words import (
    as_before_sentence,
    grown_sentence,
    hidden_sentence,
    mostly_left_sentence,
    remainder_sentence,
)
from physident.diagnosis.remainder.unexplained import Unexplained, above_noise_floor, large_as_usual
from physident.diagnosis.result.advice import design_command, other_rival
from physident.diagnosis.result.findings import Finding, JointErrors, Placebo, Rival, Unseen, UsedRecording, Verdict
from physident.diagnosis.result.simulated import Simulated
from physident.diagnosis.result.wording import (
    Asked,
    headline,
    parts_of,
    wrong_baseline_sentence,
)
from physident.dynamics.model import Model
from physident.files import VERSION
from physident.recordings.signals import Filter

Array = NDArray[np.float64]
SCHEMA = "physident.diagnosis/1"


@dataclass(frozen=True, kw_only=True, eq=False)
class DiagnosisRecord:
    """What is wrong with a model, where, how sure, and what it could be confused with.

    ``before``, ``after``: errors on the holdout, or on left-out rows without one (``scored_on``). ``model`` is the model
    that was diagnosed, ``extended`` the one with the findings, None where nothing was found. ``noise_floor`` (n,) [N m|N]
    is known where a motion repeats. ``unidentified``: base parameters that the model never identified and that were kept.
    ``incomplete``: joints (from 1) on which the model's residual on its own training recordings is still
    autocorrelated. ``simulated`` is the gain in a simulator, where it was asked for. ``warnings`` state what is wrong with the
    recordings' set-up. ``missing_since_before`` are findings that the model's own recordings show, or differ by, and ``controlled`` says
    whether a change could be held against these. ``wrong_baseline`` has the joints (from 1) on which a search that found more than
    a handful was stopped, ``wrong_unseen`` those on which the extended model errs on the holdout by far more than noise and than its values leave open. ``path`` and ``sha256`` are those of the file that it was read from;
    ``model_file`` is the file of the model, or the robot's name or file for a nominal one, and ``extended_file`` that of the
    extended model; None where they were not saved.
    """

    question: Question
    verdict: Verdict
    findings: tuple[Finding, ...]
    before: JointErrors
    after: JointErrors
    scored_on: Literal["holdout", "left-out rows"]
    noise_floor: Array | None
    placebos: tuple[Placebo, ...]
    unseen: tuple[Unseen, ...]
    unexplained: tuple[Unexplained, ...]
    recordings: tuple[UsedRecording, ...]
    model: Model
    extended: Model | None
    filter: Filter
    layout: str | None
    drive_gains: tuple[float, ...] | None
    unidentified: tuple[str, ...]
    seed: int
    incomplete: tuple[int, ...]
    recording_offsets: bool
    simulated: Simulated | None = None
    warnings: tuple[str, ...] = ()
    missing_since_before: tuple[Finding, ...] = ()
    wrong_baseline: tuple[int, ...] = ()
    wrong_unseen: tuple[int, ...] = ()
    controlled: bool | None = None
    path: Path | None = None
    sha256: str | None = None
    model_file: str | None = None
    extended_file: str | None = None

    def command(self, finding: Finding, rival: Rival | None = None) -> str:
        """The command that designs a motion to separate a finding from a ``rival``, by default its first of another effect.

        Empty where there is none. A design needs to know the noise, which a nominal model does not: it starts from the
        extended model, or from the name it is saved under by the advice.
        """
        rival = rival or other_rival(finding.effect, finding.rivals)
        if rival is None:
            return ""
        start = self.extended_file if self.question == "nominal" else self.model_file
        default = "extended.json" if self.question == "nominal" else "MODEL"
        return design_command(self.model, start or default, finding.effect, finding.joints, rival)

    @property
    def asked(self) -> Asked:
        """The question, and whether recordings from before were given, or none were at hand, to hold a change against."""
        if self.controlled is False and self.question == "different":
            return "different_or_missing"
        given = any(used.role == "before" for used in self.recordings)
        return "different_from_before" if given and self.question == "different" else self.question

    @property
    def compared(self) -> bool:
        """Whether every diagnosed recording repeats a motion from before, whose error was taken off."""
        return all(used.repeats is not None for used in self.recordings if used.role == "diagnosed")

    @property
    def motors_unknown(self) -> bool:
        """Whether what a model lacks may be ripple of motors behind gears that the robot does not state, so that it was not searched."""
        turns = any(joint.kind != "prismatic" for joint in self.model.robot.joints)
        unknown = turns and self.model.robot.motor_turns is None and self.question != "different"
        return unknown and bool(self.causes or self.structured)

    @property
    def headline(self) -> str:
        """The answer in one sentence, and where it names no cause, which joints err by far more than before."""
        more = grown_sentence(self.grown)
        return " ".join(filter(None, [headline(self.asked, self.verdict, self.findings), more]))

    @property
    def grown(self) -> tuple[Unexplained, ...]:
        """Where there is no cause, the joints that err by far more than on the model's own recordings, which nothing describes."""
        return () if self.causes else tuple(one for one in self.structured if one.grown)

    @property
    def remainder(self) -> str:
        """What is left beside what was found, in one sentence."""
        old = bool(self.missing_since_before)
        large = () if self.structured else self.large_as_usual
        said = remainder_sentence(self.verdict, self.findings, old, self.compared, bool(self.as_own), large)
        own = [one for one in self.structured if one.times_own is not None]
        as_before = self.verdict == "unexplained" and own and not self.grown and not self.mostly_unexplained
        if as_before:
            return f"{said} {as_before_sentence(own)}"
        if self.verdict == "partly_explained" and (stays := self.mostly_left):
            return f"{said} {mostly_left_sentence(stays)}"
        return f"{said} {hidden_sentence(self.may_hide)}" if self.may_hide else said

    @property
    def mostly_left(self) -> tuple[int, ...]:
        """The joints (from 1) with structure of which the causes take less than half the power of the error."""
        joints = [one.joint for one in self.structured]
        return tuple(j for j in joints if 2 * self.after.rms[j - 1] ** 2 > self.before.rms[j - 1] ** 2)

    @property
    def mostly_unexplained(self) -> bool:
        """Whether there is structure and no cause, but contributions that are proved."""
        return self.verdict == "unexplained" and bool(parts_of(self.findings))

    @property
    def may_hide(self) -> tuple[Unexplained, ...]:
        """Where nothing was found, the joints on which a change may hide in what the model errs by on any recording, those first that have
        grown most."""
        if self.verdict != "nothing_missing" or parts_of(self.findings):
            return ()
        hidden = [one for one in self.unexplained if one.may_hide_a_change]
        return tuple(sorted(hidden, key=lambda one: -(one.times_own or 0.0)))

    @property
    def unchanged(self) -> bool:
        """Whether nothing has changed, rather than that no change was found: no error of the model's own is left in which one may hide,
        because it is as small as noise or was taken off, and nothing else that is far larger than noise."""
        settled = self.compared or not (self.incomplete or self.missing_since_before)
        hides = bool(self.may_hide) or any(one.is_far_above_noise for one in self.unexplained)
        return (self.question, self.verdict) == ("different", "nothing_missing") and settled and not hides

    @property
    def outcome(self) -> str:
        """The verdict in a few words, which promise no more than the recordings show."""
        if self.mostly_unexplained:
            return "mostly unexplained"
        if self.verdict == "explained" and self.wrong_baseline:
            return "explained by more causes than these recordings can prove"
        if self.verdict != "nothing_missing":
            return self.verdict.replace("_", " ")
        if parts_of(self.findings):
            return "no main cause"
        if self.question != "different":
            return "nothing is missing"
        return "nothing has changed" if self.unchanged else "no change was found"

    @property
    def causes(self) -> tuple[Finding, ...]:
        """The findings that are causes, in the order of their evidence."""
        return tuple(f for f in self.findings if f.grade == "cause")

    @property
    def passed(self) -> tuple[Placebo, ...]:
        """The placebos that exceed the threshold, which they must not, the best first."""
        return tuple(sorted((p for p in self.placebos if p.passed), key=lambda p: -p.gain))

    @property
    def no_more_than_placebos(self) -> tuple[Finding, ...]:
        """The findings with no more evidence, on each of their joints, than a placebo that passed."""
        best = max((p.gain for p in self.passed), default=0.0)
        told = (f for f in self.findings if f.grade != "hint")
        return tuple(f for f in told if f.evidence <= best * max(len(f.joints), 1))

    @property
    def cause_alone(self) -> bool:
        """Whether the extended model carries causes, and none of the contributions beside them."""
        if self.extended is None:
            return False
        carried = {effect.name for effect in self.extended.effects} - {effect.name for effect in self.model.effects}
        lesser = {f.effect for f in self.findings if f.grade == "contribution"} - {f.effect for f in self.causes}
        return bool(lesser) and not carried & lesser

    @property
    def wrong_baseline_sentence(self) -> str:
        """What to do where the search was stopped because it found more than a handful."""
        joints = [joint - 1 for joint in self.wrong_baseline]
        holds = self.scored_on == "holdout" and bool((self.after.rms < self.before.rms)[joints].all())
        return wrong_baseline_sentence(
            self.question, self.wrong_baseline, self.causes, self.controlled, self.cause_alone, holds
        )

    @property
    def as_own(self) -> tuple[Unexplained, ...]:
        """The joints whose residual is no noise, but no larger than on the model's own recordings."""
        return tuple(one for one in self.unexplained if one.as_own)

    @property
    def large_as_usual(self) -> tuple[Unexplained, ...]:
        """The joints whose residual is several times as large as on the model's own recordings, as is usual for this model."""
        return large_as_usual(self.unexplained, self.noise_floor)

    @property
    def structured(self) -> tuple[Unexplained, ...]:
        """The joints whose residual is more than noise, by the one rule of ``unexplained.above_noise_floor``."""
        return above_noise_floor(self.unexplained, self.noise_floor)

    def short_name(self, path: str) -> str:
        """A recording's file name, or its whole path where several recordings have that name."""
        names = [Path(used.path).name for used in self.recordings]
        return Path(path).name if names.count(Path(path).name) == 1 else path

    def as_dict(self) -> dict[str, Any]:
        """The diagnosis as JSON can hold it (schema physident.diagnosis/1)."""
        return {
            "schema": SCHEMA,
            "question": self.question,
            "verdict": self.verdict,
            "headline": self.headline,
            "findings": [_plain(asdict(f)) | {"command": self.command(f)} for f in self.findings],
            "missing_since_before": [_plain(asdict(f)) for f in self.missing_since_before],
            "controlled": self.controlled,
            "wrong_baseline": list(self.wrong_baseline),
            "wrong_unseen": list(self.wrong_unseen),
            "score": {
                "before": self.before.as_dict(),
                "after": self.after.as_dict(),
                "noise_floor": None if self.noise_floor is None else self.noise_floor.tolist(),
                "on": self.scored_on,
            },
            "placebos": [_plain(asdict(p)) | {"passed": p.passed} for p in self.placebos],
            "unseen": [_plain(asdict(u)) for u in self.unseen],
            "unexplained": [one.as_dict() for one in self.unexplained],
            "recordings": [asdict(used) for used in self.recordings],
            "filter": vars(self.filter),
            "columns": self.layout,
            "drive_gains": self.drive_gains and list(self.drive_gains),
            "held": list(self.unidentified),
            "incomplete": list(self.incomplete),
            "recording_offsets": self.recording_offsets,
            "warnings": list(self.warnings),
            "seed": self.seed,
            **({} if self.simulated is None else {"simulated": _plain(asdict(self.simulated))}),
            "version": VERSION,
            "model_file": self.model_file,
            "extended_file": self.extended_file,
            "model": self.model.as_dict(),
            "extended_model": None if self.extended is None else self.extended.as_dict(),
        }


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(v) for key, v in value.items()}
    return [_plain(v) for v in value] if isinstance(value, tuple | list) else value
