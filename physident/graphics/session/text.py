"""The texts of a session: the error of each model per joint, the recordings, and the findings of a diagnosis."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.result.findings import Finding
from physident.diagnosis.result.record import DiagnosisRecord
from physident.diagnosis.result.wording import cause, in_words, listed, sense_in_words, trust_in_words
from physident.effects.catalogue import effect_label
from physident.graphics.session.data import SessionData, spans
from physident.robots.robot import Robot

Array = NDArray[np.float64]

MAX_ROWS = 12  # parameters of one finding


def summary(data: SessionData, robot: Robot, c: DiagnosisRecord | None) -> str:
    """Markdown: the error of each model per joint over all recordings, and the recordings with their roles."""
    roles = {used.sha256: used.role for used in c.recordings} if c is not None else {}
    lines = []
    if data.predictions:
        names = [p.name for p in data.predictions]
        lines += [f"**RMS residual** [{robot.torque_unit}], and in % of the joint's RMS torque", ""]
        lines += [_row(["joint", *names]), _row(["---"] * (len(names) + 1))]
        for j, name in enumerate(robot.joint_names):
            size = _rms(data.measured[:, j])
            cells = [f"{e:.3g} ({_share(e, size)})" for e in (_rms(data.residual(p)[:, j]) for p in data.predictions)]
            lines.append(_row([f"{j + 1} {name}", *cells]))
    heads = ["recording", "from", "to", *(["role"] if roles else [])]
    lines += ["", _row(heads), _row(["---"] * len(heads))]
    for r, start, end in spans(data):
        role = [roles.get(r.sha256, "not in the diagnosis")] if roles else []
        lines.append(_row([_file(r.source), f"{start:.1f} s", f"{end:.1f} s", *role]))
    return "\n".join(lines) + "\n"


def findings(c: DiagnosisRecord) -> str:
    """Markdown: the verdict, each finding with its numbers, rivals and advice, unexplained structure, unseen effects."""
    lines = [f"# {c.headline}", "", c.remainder, ""]
    for number, finding in enumerate(c.findings, 1):
        lines += _finding(number, finding)
        if command := c.command(finding):
            lines += ["Design a motion that separates them:", "", "```sh", command, "```", ""]
    if old := c.missing_since_before:
        names = "; ".join(cause(finding.effect, finding.joints) for finding in old)
        lines += [f"**Missing since before**, as the model's own recordings show, or differ by as much: {names}.", ""]
    if left := c.structured:
        sizes = ", ".join(f"{r.rms:.3g} on joint {r.joint}" for r in left)
        lines += [f"**Unexplained structure** [N m RMS]: {sizes}.", ""]
    unseen: dict[str, set[int]] = {}
    for one in c.unseen:
        unseen.setdefault(one.effect, set()).update(one.joints)
    if unseen:
        effects = "; ".join(cause(effect, sorted(joints)) for effect, joints in unseen.items())
        lines += [f"**Not visible in these recordings**: {effects}.", ""]
    return "\n".join(lines) + "\n"


def _finding(number: int, finding: Finding) -> list[str]:
    gain, (low, high) = finding.gain, finding.gain.interval95
    lines = [
        f"## {number}. {cause(finding.effect, finding.joints)}"
        + ("" if finding.grade == "cause" else f" ({finding.grade})"),
        "",
        f"Residual {gain.rms_before:.3g} → {gain.rms_after:.3g} N m RMS on left-out rows:"
        f" **{gain.reduction_percent:.0f} % less** (95 %: {round(low)} to {round(high)} %).",
        "",
        _row(["parameter", "joint", "value", "95 % interval", "unit"]),
        _row(["---"] * 5),
    ]
    for v in finding.parameters[:MAX_ROWS]:
        interval = f"{v.change_interval95[0]:.3g} to {v.change_interval95[1]:.3g}"
        value = f"{v.value:.4g}" if v.change == v.value else f"changed by {v.change:+.4g} to {v.value:.4g}"
        lines.append(_row([effect_label(v.name), str(v.joint or ""), value, interval, v.unit]))
    if len(finding.parameters) > MAX_ROWS:
        lines.append(_row([f"and {len(finding.parameters) - MAX_ROWS} more", "", "", "", ""]))
    lines.append("")
    if finding.intervals:
        times = ", ".join(f"{a:.1f} to {b:.1f} s" for a, b in finding.intervals)
        lines += [f"Time on the recording's clock: {times}.", ""]
    if finding.rivals:
        rivals = listed([cause(r.effect, r.joints) for r in finding.rivals])
        lines += [f"These recordings cannot separate it from {rivals}.", ""]
    texts = (sense_in_words(finding), trust_in_words(finding), finding.advice)
    lines += [f"{text[0].upper()}{text[1:]}\n" for text in map(in_words, texts) if text]
    return lines


def _row(cells: list[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "/") for cell in cells) + " |"


def _file(source: str) -> str:
    return source.replace("\\", "/").rsplit("/", 1)[-1]


def _rms(values: Array) -> float:
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else 0.0


def _share(part: float, whole: float) -> str:
    return f"{100 * part / whole:.1f} %" if whole > 0 else "no torque"
