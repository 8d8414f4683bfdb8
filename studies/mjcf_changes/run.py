# fast
"""Is a number that was changed in a MuJoCo file named, and with its value?"""

from __future__ import annotations

import re
import sys
import tempfile
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import physident as pid
from studies.kept import keep
from tests.mujoco_recording import record, written
from tests.vendor_robots import mjcf

JOINTS, BODIES = ("pan", "lift", "elbow", "wrist"), ("shoulder", "upper", "fore", "hand")
EFFECTS = {"damping": "viscous_friction", "frictionloss": "coulomb_friction", "armature": "rotor_inertia"}
LARGER = 1.3  # times the recorded arm's, for damping, frictionloss and armature
HEAVIER = 1.2
GRAVITIES = (-10.3, -9.9, -9.3, -1.62)  # m/s^2, the recorded arm's is -9.81


@dataclass(frozen=True, kw_only=True)
class Change:
    """One changed number: the file's text, and the effect, joint (0: the whole arm) and value that a diagnosis must give."""

    name: str
    text: str
    effect: str
    joint: int
    value: float | None


def changes() -> list[Change]:
    """Every number of the file that is changed, one at a time."""
    found = []
    for attribute, effect in EFFECTS.items():
        for j, joint in enumerate(JOINTS, 1):
            text, value = _changed(rf'(name="{joint}"[^>]*{attribute}=")([^"]*)', LARGER)
            found.append(Change(name=f"{attribute} of {joint}", text=text, effect=effect, joint=j, value=value))
    for j, body in enumerate(BODIES, 1):
        text, mass = _changed(rf'(<body name="{body}".*?<inertial[^>]*mass=")([^"]*)', HEAVIER)
        name, value = f"mass of {body}", (1 - HEAVIER) * mass
        if j == 1:  # on a vertical axis through its centre of mass: no torque shows it
            found.append(Change(name=name, text=text, effect="", joint=0, value=None))
        elif j == len(BODIES):
            found.append(Change(name=name, text=text, effect="payload", joint=0, value=value))
        else:  # torques show sums with the masses behind it
            found.append(Change(name=name, text=text, effect="link_inertia", joint=j, value=None))
    for g in GRAVITIES:
        text = mjcf(option=f'<option gravity="0 0 {g}"/>')
        found.append(Change(name=f"gravity {g:g}", text=text, effect="gravity_magnitude", joint=0, value=9.81 + g))
    tilted = mjcf(option='<option gravity="0.3 0 -9.81"/>')
    return [
        *found,
        Change(name="gravity tilted by 0.3", text=tilted, effect="gravity_tilt", joint=0, value=-0.3),
        Change(name="nothing", text=mjcf(), effect="", joint=0, value=None),
    ]


def _changed(pattern: str, factor: float) -> tuple[str, float]:
    """The file with one number times ``factor``, and the number as it was."""
    found = re.search(pattern, mjcf(), flags=re.S)
    assert found is not None
    value = float(found.group(2))
    text = mjcf()[: found.start(2)] + repr(factor * value) + mjcf()[found.end(2) :]
    return text, value


def judged(change: Change, runs: list[str], folder: Path) -> dict[str, Any]:
    """What a diagnosis of the changed file says."""
    path = folder / "changed.xml"
    path.write_text(change.text)
    with warnings.catch_warnings(action="ignore", category=pid.PhysidentWarning):
        found = pid.diagnose_motion(pid.Model.described(pid.load_robot(path)), runs)
    causes = [_told(finding) for finding in found.causes]
    first = found.causes[0] if found.causes else None
    values = {v.joint: v.value for v in first.parameters} if first else {}
    # the values of a link are those of its joint; of the whole arm, the first
    value = None if first is None else values.get(change.joint, first.parameters[0].value)
    right = first is not None and first.effect == change.effect and (not change.joint or change.joint in first.joints)
    return {
        "changed": change.name,
        "expected": f"{change.effect} {change.joint or ''}".strip(),
        "named_first": right if change.effect else not causes,
        "true_value": change.value,
        "value": value if right and change.value is not None else None,
        "causes": causes,
        "contributions": [_told(finding) for finding in found.findings if finding.grade != "cause"],
        "verdict": found.verdict,
    }


def _told(finding: pid.Finding) -> str:
    names = [(finding.effect, finding.joints), *((rival.effect, rival.joints) for rival in finding.rivals)]
    return " or ".join(f"{effect} {','.join(map(str, joints))}".strip() for effect, joints in names)


def main() -> None:
    rows: list[dict[str, Any]] = []
    lines = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for noise, title in ((1.0, "recordings with noise of 0.05 N m"), (0.0, "noise-free recordings")):
            runs = [written(folder, f"{seed}.csv", record(mjcf(), seed, noise=noise)) for seed in (1, 2)]
            part = [{"noise": noise, **judged(change, runs, folder)} for change in changes()]
            rows += part
            right = sum(row["named_first"] for row in part)
            lines += [f"{title}: {right} of {len(part)} right", *map(_line, part), ""]
    keep(Path(__file__).parent, {"rows": rows}, "\n".join(lines).rstrip())


def _line(row: dict[str, Any]) -> str:
    value = "" if row["value"] is None else f"{row['value']:.4g} (true {row['true_value']:.4g})"
    mark = "  " if row["named_first"] else "- "
    small = f"   (contributions: {'; '.join(row['contributions'])})" if row["contributions"] else ""
    return f"{mark}{row['changed']:<24}{'; '.join(row['causes']) or 'nothing':<44}{value:<26}{small}".rstrip()


if __name__ == "__main__":
    main()
