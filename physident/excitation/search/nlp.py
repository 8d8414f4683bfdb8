"""IPOPT on a problem whose functions and gradients are NumPy's."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
OPTIONS = {
    "print_level": 0,
    "sb": "yes",
    "hessian_approximation": "limited-memory",
    "limited_memory_max_history": 12,
    "limited_memory_aug_solver": "extended",  # a tenth of the back-substitutions that Sherman and Morrison need
    "mu_strategy": "adaptive",
    "jacobian_approximation": "exact",
    "tol": 1e-4,
    "constr_viol_tol": 1e-6,
    "acceptable_iter": 8,
    "acceptable_tol": 1e-2,
    "acceptable_constr_viol_tol": 1e-6,
    "acceptable_obj_change_tol": 1e-4,
}


@dataclass(frozen=True, eq=False)
class Rows:
    """Constraints lower <= g(y) <= upper, (C,) each, in units of the limit: ``value`` gives g(y), ``jacobian`` its
    non-zeros in the order of ``pattern`` (E, 2), row and free number."""

    lower: Array
    upper: Array
    pattern: NDArray[np.intp]
    value: Callable[[Array], Array]
    jacobian: Callable[[Array], Array]

    def slack(self, y: Array) -> Array:
        """How far (C,) each row is from its nearer limit, negative beyond it."""
        value = self.value(y)
        return np.minimum(value - self.lower, self.upper - value)

    def excess(self, y: Array) -> float:
        """By how much the worst row is exceeded; zero where all hold."""
        return max(0.0, -float(self.slack(y).min()))

    def penalty(self, y: Array, reserve: float) -> tuple[float, Array]:
        """Sum of the squares of what is missing to ``reserve`` [units of the limit] inside each limit, and its gradient."""
        value = self.value(y)
        below, above = np.maximum(self.lower + reserve - value, 0.0), np.maximum(value - self.upper + reserve, 0.0)
        slope = 2 * (above - below)
        if not slope.any():
            return 0.0, np.zeros(y.size)
        weighted = self.jacobian(y) * slope[self.pattern[:, 0]]
        gradient = np.zeros(y.size)
        np.add.at(gradient, self.pattern[:, 1], weighted)
        return float(below @ below + above @ above), gradient

    def only(self, chosen: NDArray[np.bool_]) -> Rows:
        """Some of the rows (C,)."""
        kept = chosen[self.pattern[:, 0]]
        place = np.cumsum(chosen) - 1
        pattern = np.column_stack([place[self.pattern[kept, 0]], self.pattern[kept, 1]])
        return Rows(
            self.lower[chosen], self.upper[chosen], pattern,
            lambda y: self.value(y)[chosen], lambda y: self.jacobian(y)[kept],
        )  # fmt: skip


def join(one: Rows, other: Rows) -> Rows:
    """Two sets of constraints as one."""
    shifted = other.pattern + np.array([len(one.lower), 0])
    return Rows(
        np.concatenate([one.lower, other.lower]),
        np.concatenate([one.upper, other.upper]),
        np.concatenate([one.pattern, shifted]),
        lambda y: np.concatenate([one.value(y), other.value(y)]),
        lambda y: np.concatenate([one.jacobian(y), other.jacobian(y)]),
    )


def minimise(
    function: Callable[[Array], tuple[float, Callable[[], Array]]],
    rows: Rows,
    y: Array,
    iterations: int,
    passed: Callable[[Array], None] = lambda _: None,
) -> Array:
    """Where IPOPT ends (m,), minimising a function within rows from ``y`` (m,) on; the caller judges what that is worth.

    The function returns its value, and what returns its gradient (m,): most points of a line search are not asked for it.
    ``passed`` hears the point after each iteration.
    """
    size = y.size
    last: list[Any] = [b"", 0.0, None]

    def at(x: Array) -> list[Any]:
        if last[0] != x.tobytes():
            value, slope = function(x)
            last[:] = [x.tobytes(), value, slope]
        return last

    def both(x: Array) -> list[Any]:
        now = at(x)
        return [now[1], now[2]()]

    count = len(rows.lower)
    order = np.lexsort((rows.pattern[:, 0], rows.pattern[:, 1]))  # CasADi keeps non-zeros by column
    sparsity = ca.Sparsity.triplet(count, size, rows.pattern[order, 0].tolist(), rows.pattern[order, 1].tolist())
    dense, vector = ca.Sparsity.dense(size, 1), ca.Sparsity.dense(count, 1)
    scalar, empty = ca.Sparsity.dense(1, 1), ca.Sparsity(0, 0)
    nlp = _Call(
        "nlp", [("x", dense), ("p", empty)], [("f", scalar), ("g", vector)], lambda x: [at(x)[1], rows.value(x)]
    )
    grad = _Call("nlp_grad_f", [("x", dense), ("p", empty)], [("f", scalar), ("grad_f_x", dense)], both)
    jac = _Call(
        "nlp_jac_g", [("x", dense), ("p", empty)], [("g", vector), ("jac_g_x", sparsity)],
        lambda x: [rows.value(x), ca.DM(sparsity, rows.jacobian(x)[order])],
    )  # fmt: skip
    options = {
        "ipopt": OPTIONS | {"max_iter": iterations},
        "print_time": False,
        "error_on_fail": False,
        "no_nlp_grad": True,
    }
    shapes = (size, 1, count, size, count, 0)  # of x, f, g and the multipliers of x, g and p
    with _held_interrupt() as pressed:
        told = [(name, ca.Sparsity.dense(k, 1)) for name, k in zip(ca.nlpsol_out(), shapes, strict=True)]
        begun: list[bool] = []

        def after(x: Array) -> list[int]:
            if begun and np.isfinite(x).all():  # the first call is for the start
                passed(x)
            begun.append(True)
            return [len(pressed)]

        heard = _Call("heard", told, [("stop", scalar)], after)
        solver = ca.nlpsol(
            "solver", "ipopt", nlp, options | {"grad_f": grad, "jac_g": jac, "iteration_callback": heard}
        )
        found = solver(x0=y, lbg=rows.lower, ubg=rows.upper)
    return np.asarray(found["x"]).ravel()


@contextmanager
def _held_interrupt() -> Iterator[list[int]]:
    """Signals of Ctrl-C that came inside, handled as usual after: CasADi would take one for a point without a value."""
    usual, pressed = signal.getsignal(signal.SIGINT), []
    held = callable(usual) and threading.current_thread() is threading.main_thread()
    if held:
        signal.signal(signal.SIGINT, lambda number, _: pressed.append(number))
    try:
        yield pressed
    finally:
        if held:
            signal.signal(signal.SIGINT, usual)
    if pressed and callable(usual):
        usual(pressed[0], None)


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
