"""How long does a diagnosis of eight real recordings take, and what would the plain way cost: one refit for each surrogate?"""

from __future__ import annotations

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from kept import UR10E_COLUMNS, UR10E_GAINS, keep, need_data

import physident as pid
from physident.diagnosis.problem.problem import state_problem
from physident.diagnosis.problem.question import choose_question
from physident.diagnosis.search.candidate_scores import surrogate_responses
from physident.diagnosis.search.forward_search import settled_hypothesis
from physident.diagnosis.search.thresholds import SURROGATES
from physident.diagnosis.statistics.left_out_gains import left_out_gains
from physident.diagnosis.statistics.left_out_residuals import LeftOutFits
from physident.estimation.identify import prepare_all

PLAIN = 40  # candidates whose left-out residuals are computed row by row, to know what one costs


def main() -> None:
    data = need_data("ur10e")
    paths = sorted(data.glob("ur-20_02_*.csv"))
    recordings = pid.load_recordings(paths, UR10E_COLUMNS, UR10E_GAINS)
    estimate = pid.identify(pid.load_robot(data / "ur10e.urdf"), recordings)
    begun = time.perf_counter(), time.process_time()
    diagnosis = pid.diagnose_motion(estimate, recordings)
    elapsed, processor = time.perf_counter() - begun[0], time.process_time() - begun[1]
    options, look, plain = one_look(estimate, recordings)
    results = {
        "recordings": len(recordings), "seconds": sum(r.duration for r in recordings), "elapsed_s": elapsed,
        "processor_s": processor, "findings": len(diagnosis.findings), "surrogates": SURROGATES, "options": options,
        "one_look_s": look, "plain_look_s": plain, "ratio": plain / look,
    }  # fmt: skip
    rows = [
        f"{'':<66}{'seconds':>10}",
        f"{'diagnosis of ' + str(len(recordings)) + ' runs, whole catalogue, elapsed':<66}{elapsed:>10.1f}",
        f"{'  processor time, one core':<66}{processor:>10.1f}",
        f"{f'one look at {options} columns with shapes beside {SURROGATES} surrogates':<66}{look:>10.2f}",
        f"{'the same row by row, from the time of ' + str(PLAIN):<66}{plain:>10.0f}",
        f"ratio {plain / look:.0f}",
    ]
    keep(Path(__file__).parent, results, "\n".join(rows))


def one_look(estimate: pid.Estimate, recordings: list[pid.Recording]) -> tuple[int, float, float]:
    """Number of options, and processor time [s] of judging all of them on all surrogate_responses, here and row by row."""
    import numpy as np

    robot, filter = estimate.model.robot, estimate.filter
    case = state_problem(
        choose_question(estimate, recordings), estimate, prepare_all(robot, recordings, filter), filter, 0
    )
    state = settled_hypothesis(case, ())
    responses = np.concatenate([state.data.response[:, :, None], surrogate_responses(state)], axis=2)
    begun = time.process_time()
    left_out_gains(state.data, state.baseline, state.fit, responses)
    look = time.process_time() - begun
    options = [option for c in state.data.candidates for option in c.options]
    chosen = options[:: max(1, len(options) // PLAIN)][:PLAIN]
    begun = time.process_time()
    for option in chosen:
        folded = LeftOutFits(state.data, state.baseline, state.fit.weights)  # one refit for each surrogate
        folded.residual([state.data.columns(option.columns)])
    each = (time.process_time() - begun) / len(chosen)
    return len(options), look, each * len(options) * responses.shape[2]


if __name__ == "__main__":
    main()
