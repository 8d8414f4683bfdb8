"""IPOPT, through CasADi, on functions and gradients that are written in NumPy."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from physident.excitation.limits.constraints import Constraints
from physident.outputs import STOPPING

Array = NDArray[np.float64]
OPTIONS = {
    "print_level": 0,
    "sb": "yes",
    "hessian_approximation": "limited-memory",
    "limited_memory_max_history": 12,
    "limited_memory_aug_solver": "extended",  # a tenth of the back-substitutions of the default
    "mu_strategy": "adaptive",
    "jacobian_approximation": "exact",
    "tol": 1e-4,
    "constr_viol_tol": 1e-6,
    "acceptable_iter": 8,
    "acceptable_tol": 1e-2,
    "acceptable_constr_viol_tol": 1e-6,
    "acceptable_obj_change_tol": 1e-4,
}


def minimise(
    function: Callable[[Array], tuple[float, Callable[[], Array]]],
    constraints: Constraints,
    y: Array,
    iterations: int,
    on_iteration: Callable[[Array], None] = lambda _: None,
) -> Array:
    """The point (m,) at which IPOPT ends, started from ``y`` (m,); the caller checks what it is worth.

    ``function`` returns its value, and a function that returns its gradient (m,): most points of a line search need no
    gradient. ``on_iteration`` is called with the point after each iteration.
    """
    size = y.size
    latest: list[Any] = [b"", 0.0, None]  # the point, its value, and the function for its gradient

    def evaluated(x: Array) -> list[Any]:
        if latest[0] != x.tobytes():
            value, gradient = function(x)
            latest[:] = [x.tobytes(), value, gradient]
        return latest

    def value_and_gradient(x: Array) -> list[Any]:
        _, value, gradient = evaluated(x)
        return [value, gradient()]

    count = len(constraints.lower)
    order = np.lexsort((constraints.pattern[:, 0], constraints.pattern[:, 1]))  # CasADi keeps non-zeros by column
    sparsity = ca.Sparsity.triplet(
        count, size, constraints.pattern[order, 0].tolist(), constraints.pattern[order, 1].tolist()
    )
    dense, vector = ca.Sparsity.dense(size, 1), ca.Sparsity.dense(count, 1)
    scalar, empty = ca.Sparsity.dense(1, 1), ca.Sparsity(0, 0)
    nlp = _Call(
        "nlp",
        [("x", dense), ("p", empty)],
        [("f", scalar), ("g", vector)],
        lambda x: [evaluated(x)[1], constraints.value(x)],
    )
    grad = _Call("nlp_grad_f", [("x", dense), ("p", empty)], [("f", scalar), ("grad_f_x", dense)], value_and_gradient)
    jac = _Call(
        "nlp_jac_g", [("x", dense), ("p", empty)], [("g", vector), ("jac_g_x", sparsity)],
        lambda x: [constraints.value(x), ca.DM(sparsity, constraints.jacobian(x)[order])],
    )  # fmt: skip
    options = {
        "ipopt": OPTIONS | {"max_iter": iterations},
        "print_time": False,
        "show_eval_warnings": False,  # a step to where nothing can be computed is taken back; CasADi would print a line
        "error_on_fail": False,
        "no_nlp_grad": True,
    }
    lengths = (size, 1, count, size, count, 0)  # of x, f, g and the multipliers of x, g and p
    with _deferred_interrupt() as signals:
        outputs = [(name, ca.Sparsity.dense(k, 1)) for name, k in zip(ca.nlpsol_out(), lengths, strict=True)]
        started: list[bool] = []

        def after_iteration(x: Array) -> list[int]:
            if started and np.isfinite(x).all():  # the first call is for the starting point
                on_iteration(x)
            started.append(True)
            return [len(signals)]  # anything but zero stops the solver

        callback = _Call("after_iteration", outputs, [("stop", scalar)], after_iteration)
        solver = ca.nlpsol(
            "solver", "ipopt", nlp, options | {"grad_f": grad, "jac_g": jac, "iteration_callback": callback}
        )
        result = solver(x0=y, lbg=constraints.lower, ubg=constraints.upper)
    return np.asarray(result["x"]).ravel()


@contextmanager
def _deferred_interrupt() -> Iterator[list[int]]:
    """Collects Ctrl-C and a termination inside the block and handles the first of them after it.

    Inside, CasADi would take the exception for a function value that cannot be computed, and go on.
    """
    signals: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield signals
        return
    usual = {number: handler for number in STOPPING if callable(handler := signal.getsignal(number))}
    for number in usual:
        signal.signal(number, lambda number, _: signals.append(number))
    try:
        yield signals
    finally:
        for number, handler in usual.items():
            signal.signal(number, handler)
    if signals:
        usual[signal.Signals(signals[0])](signals[0], None)


class _Call(ca.Callback):
    """A Python function of x as a CasADi function with an empty parameter p."""

    def __init__(self, name: str, inputs: list, outputs: list, function: Callable[[Array], list]) -> None:
        ca.Callback.__init__(self)
        self.inputs, self.outputs, self.function = inputs, outputs, function
        self.construct(name, {})

    def get_n_in(self) -> int:
        return len(self.inputs)

    def get_n_out(self) -> int:
        return len(self.outputs)

    def get_name_in(self, i: int) -> str:
        return self.inputs[i][0]

    def get_name_out(self, i: int) -> str:
        return self.outputs[i][0]

    def get_sparsity_in(self, i: int) -> Any:
        return self.inputs[i][1]

    def get_sparsity_out(self, i: int) -> Any:
        return self.outputs[i][1]

    def eval(self, arg: Any) -> list:
        return self.function(np.asarray(arg[0]).ravel())
