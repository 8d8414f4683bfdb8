"""How long does a diagnosis of eight real recordings take, and what would the plain way cost: one refit for each surrogate?"""

from __future__ import annotations

import resource
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from kept import UR10E_COLUMNS, UR10E_GAINS, keep, need_data

import physident as pid
from physident.diagnosis.problem.problem import DiagnosisProblem, state_problem
from physident.diagnosis.problem.question import choose_question
from physident.diagnosis.search.candidate_scores import surrogate_responses
from physident.diagnosis.search.forward_search import search_effects, settled_hypothesis
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.statistics.left_out_gains import left_out_gains
from physident.diagnosis.statistics.thresholds import SURROGATES
from physident.estimation.identify import prepare_all

PLAIN = 40  # candidates whose left-out residuals are computed row by row, to know what one costs


def main() -> None:
    data = need_data("ur10e")
    paths = sorted(data.glob("ur-20_02_*.csv"))
    recordings = pid.load_recordings(paths, UR10E_COLUMNS, UR10E_GAINS)
    estimate = pid.identify(pid.load_robot(data / "ur10e.urdf"), recordings)
    before, begun = memory(), (time.perf_counter(), processor())
    diagnosis = pid.diagnose_motion(estimate, recordings)
    elapsed, used, after = time.perf_counter() - begun[0], processor() - begun[1], memory()
    case = stated(estimate, recordings)
    start = processor()
    search_effects(case)
    search = processor() - start
    options, look, plain = one_look(settled_hypothesis(case, ()))
    results = {
        "recordings": len(recordings), "seconds": sum(r.duration for r in recordings), "elapsed_s": elapsed,
        "processor_s": used, "search_s": search, "memory_before_GB": before, "memory_GB": after,
        "findings": len(diagnosis.findings), "surrogates": SURROGATES, "options": options,
        "one_look_s": look, "plain_look_s": plain, "ratio": plain / look,
    }  # fmt: skip
    rows = [
        f"{'':<66}{'seconds':>10}",
        f"{'diagnosis of ' + str(len(recordings)) + ' runs, whole catalogue, elapsed':<66}{elapsed:>10.1f}",
        f"{'  processor time of all processes':<66}{used:>10.1f}",
        f"{'  of which the search for effects':<66}{search:>10.1f}",
        f"{f'one look at {options} columns with shapes beside {SURROGATES} surrogates':<66}{look:>10.2f}",
        f"{'the same row by row, from the time of ' + str(PLAIN):<66}{plain:>10.0f}",
        f"ratio {plain / look:.0f}",
        f"largest resident size: {before:.2f} GB before the diagnosis, {after:.2f} GB after it",
    ]
    keep(Path(__file__).parent, results, "\n".join(rows))


def processor() -> float:
    """Processor time [s] of this process and of its helpers that have ended."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


def memory() -> float:
    """Largest resident size [GB] of this process so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6


def stated(estimate: pid.Estimate, recordings: list[pid.Recording]) -> DiagnosisProblem:
    """The problem as ``diagnose`` states it."""
    signals = prepare_all(estimate.model.robot, recordings, estimate.filter)
    return state_problem(choose_question(estimate, recordings), estimate, signals, estimate.filter, 0)


def one_look(state: Hypothesis) -> tuple[int, float, float]:
    """Number of options, and processor time [s] of judging all of them on all surrogates, here and row by row."""
    import numpy as np

    responses = np.concatenate([state.data.response[:, :, None], surrogate_responses(state)], axis=2)
    begun = time.process_time()
    left_out_gains(state.data, state.baseline, state.fit, responses)
    look = time.process_time() - begun
    options = [option for c in state.data.candidates for option in c.options]
    chosen = options[:: max(1, len(options) // PLAIN)][:PLAIN]
    begun = time.process_time()
    for option in chosen:
        refit(state, option.columns)  # one refit for each surrogate
    each = (time.process_time() - begun) / len(chosen)
    return len(options), look, each * len(options) * responses.shape[2]


def refit(state: Hypothesis, columns: tuple[int, ...]) -> float:
    """Squared left-out residual of the baseline and some columns, refitted to the rows outside each fold."""
    import numpy as np

    data, total = state.data, 0.0
    more = data.columns(columns)
    rows = [np.column_stack([B, more[j]]) * state.fit.weights[j] for j, B in enumerate(state.baseline.joints)]
    response = data.response * state.fit.weights
    for fold in np.unique(data.fold[data.fold >= 0]):
        test, train = data.fold == fold, (data.fold >= 0) & (data.fold != fold)
        normal = np.sum([A[train].T @ A[train] for A in rows], axis=0)
        slope = np.sum([A[train].T @ y[train] for A, y in zip(rows, response.T, strict=True)], axis=0)
        x = np.linalg.lstsq(normal, slope, rcond=1e-10)[0]
        total += sum(float(np.sum((y[test] - A[test] @ x) ** 2)) for A, y in zip(rows, response.T, strict=True))
    return total


if __name__ == "__main__":
    main()
