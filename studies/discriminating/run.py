"""Where ordinary motions left two rivals in one class, does the designed motion tell them apart?"""

from __future__ import annotations

import json
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy loads: one process a core

import sys
from multiprocessing import Pool
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import physident as pid
from physident.excitation.design_discriminating import design_discriminating
from studies.blind_trials.arms import CACHE, FILTER, STEP
from studies.blind_trials.run import rows_of
from studies.blind_trials.trial import Prepared, Scene, prepare
from studies.designed_plant import Plan
from studies.kept import keep
from tests.plant import Sensors, hide, record

GROUPS = (1, 2)  # of seeds
SAME = "same effect on another joint, or a contact"


def undecided() -> list[dict[str, Any]]:
    """Trials whose first finding was the truth, in a class with a rival."""
    rows = [json.loads(text) for group in GROUPS for text in rows_of(group).read_text(encoding="utf-8").splitlines()]
    chosen = [r for r in rows if len(r["hidden"]) == 1 and r["score"]["first"] and not r["score"]["alone"]]
    return sorted((r for r in chosen if r["tier"] in ("middle", "strong")), key=lambda r: (r["group"], r["number"]))


def rival_of(row: dict[str, Any]) -> str | None:
    """The first rival that a motion can tell apart: another effect."""
    (hidden,) = row["hidden"]
    names = [part.split()[0] for part in row["score"]["told"].split("; ")[0].split(" or ")]
    others = [name for name in names if name not in (hidden["effect"], "contact")]
    return others[0] if others and hidden["effect"] != "contact" else None


def judged(row: dict[str, Any]) -> dict[str, Any]:
    """One trial again, on the motion designed for its two rivals."""
    rival = rival_of(row)
    prepared = prepare(row["group"], row["number"], pair=False)
    (hidden,) = prepared.trial.hidden
    result = {
        "group": row["group"],
        "number": row["number"],
        "question": row["question"],
        "hidden": hidden.effect,
        "joints": list(hidden.joints),
    }
    if rival is None:
        return result | {"rival": None, "told": SAME, "separated": None}
    joint = hidden.joints[0] if len(hidden.joints) == 1 else None
    try:
        design = design_discriminating(known(prepared), hidden.effect, rival, joint, limits="joint", seed=row["number"])
    except (pid.InputError, pid.NotSolvedError) as error:
        return result | {"rival": rival, "told": str(error), "separated": None}
    found = asked(prepared, Plan(design.design.trajectory))
    told = [[f.effect, list(f.joints), [[r.effect, list(r.joints)] for r in f.rivals]] for f in found.findings]
    truth = [hidden.effect, list(hidden.joints)]
    named = [told[0][:2], *told[0][2]] if told else []
    separated = truth in named and rival not in [name for name, _ in named]
    return result | {"rival": rival, "told": told, "separated": separated, "alone": named == [truth]}


def known(prepared: Prepared) -> pid.Estimate | pid.Model:
    """The model that a user has when the advice is given."""
    if isinstance(prepared.model, pid.Model):  # the extended one: a nominal model knows no noise
        found = pid.diagnose_motion(prepared.model, [t.recording for t in prepared.changed[:2]], filter=FILTER)
        assert found.estimate is not None
        return found.estimate
    if prepared.trial.question != "missing":
        return prepared.model
    return pid.identify(pid.load_robot("ur5"), [t.recording for t in prepared.changed[:2]], filter=FILTER)


def asked(prepared: Prepared, plan: Plan) -> pid.Diagnosis:
    """The same question of two recordings of the designed motion."""
    trial = prepared.trial
    scene = Scene.of(trial.group, trial.number)
    (hidden,) = trial.hidden
    size, shape = hidden.doses()
    arm = hide(scene.arm, hidden.effect, hidden.joints, size, **shape)
    folder = CACHE / "discriminating" / f"{trial.group}_{trial.number:04d}"
    folder.mkdir(parents=True, exist_ok=True)
    for k in range(2):
        record(arm, plan, Sensors(), 10 * trial.number + k, step=STEP).write_csv(folder / f"{k}.csv")
    runs = pid.load_recordings([folder / f"{k}.csv" for k in range(2)])
    model = prepared.model
    if trial.question == "missing":
        model = pid.identify(pid.load_robot("ur5"), runs, filter=FILTER)
    return pid.diagnose_motion(model, runs, filter=FILTER if isinstance(model, pid.Model) else None)


def main() -> None:
    with Pool(2) as pool:
        rows = pool.map(judged, undecided(), chunksize=1)
    tried = [row for row in rows if row["separated"] is not None]
    done = sum(row["separated"] for row in tried)
    lines = [f"{'set, trial':>10}  {'question':<10}{'hidden':<30}{'rival':<30}on the designed motion"]
    for row in rows:
        where = f"{row['hidden']} {','.join(map(str, row['joints']))}"
        told = row["told"] if isinstance(row["told"], str) else "; ".join(_said(*t) for t in row["told"]) or "nothing"
        lines.append(
            f"{row['group']:>4}, {row['number']:>4}  {row['question']:<10}{where:<30}{row['rival'] or '-':<30}{told}"
        )
    alone = sum(row["alone"] for row in tried)
    lines.append(f"told apart from the rival: {done} of {len(tried)}; with no other rival either: {alone}")
    keep(Path(__file__).parent, {"rows": rows, "separated": done, "alone": alone, "of": len(tried)}, "\n".join(lines))


def _said(effect: str, joints: list[int], rivals: list[Any]) -> str:
    return " or ".join(f"{name} {','.join(map(str, own))}".strip() for name, own in [(effect, joints), *rivals])


if __name__ == "__main__":
    main()
