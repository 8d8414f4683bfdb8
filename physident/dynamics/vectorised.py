"""CasADi functions of one sample, evaluated for arrays of samples.

The instruction list of the function is run on NumPy rows, in chunks of samples that fit the cache. Values that do not
depend on the sample (constants and parameters) are computed once as numbers, not as rows.
"""

from __future__ import annotations

from functools import partial
from operator import itemgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
CHUNK = 2048  # samples: long enough to hide NumPy's call overhead, short enough for a second-level cache


class Vectorised:
    """A CasADi ``function`` of a sample's inputs (k,) and, where it has a second argument, of parameters (p,).

    Values are addressed by their place: first the work rows, then inputs, outputs, parameters and computed numbers.
    """

    def __init__(self, function: Any) -> None:
        self._slots, self._inputs, self._outputs = function.sz_w(), function.nnz_in(0), function.nnz_out(0)
        self._parameters = function.nnz_in(1) if function.n_in() > 1 else 0
        self._numbers: list[
            tuple[Any, tuple[int, ...]]
        ] = []  # operation and the places of its operands; each gives one number
        self._rows: list[tuple[Any, Any]] = []  # operation and getter of its operands and its target
        self._read(function)

    def _read(self, function: Any) -> None:
        import casadi as ca

        operations, outputs = _operations(ca), self._slots + self._inputs
        parameters = outputs + self._outputs
        computed = parameters + self._parameters
        place: dict[int, int] = {}  # of the value in each work slot
        for k in range(function.n_instructions()):
            op, source, target = (
                function.instruction_id(k),
                function.instruction_input(k),
                function.instruction_output(k),
            )
            if op == ca.OP_INPUT:
                place[target[0]] = (self._slots, parameters)[source[0]] + source[1]
                continue
            if op == ca.OP_OUTPUT:
                self._rows.append((np.positive, itemgetter(place[source[0]], outputs + target[1])))
                continue
            if op == ca.OP_CONST:
                operation, operands = partial(float, function.instruction_constant(k)), ()
            else:
                operation, count = operations[op]
                operands = tuple(place[s] for s in (*source, source[0])[:count])
            if all(at >= parameters for at in operands):
                place[target[0]] = computed + len(self._numbers)
                self._numbers.append((operation, tuple(at - parameters for at in operands)))
            else:
                place[target[0]] = target[0]
                self._rows.append((operation, itemgetter(*operands, target[0])))

    def run(self, inputs: Array, parameters: Array | tuple[float, ...] = ()) -> Array:
        """Structural non-zeros (E, N) of the function's value for inputs (k, N) and parameters (p,)."""
        N = inputs.shape[1]
        assert (len(inputs), len(parameters)) == (self._inputs, self._parameters)
        numbers = [np.array(x, dtype=float) for x in parameters]
        for operation, operands in self._numbers:
            numbers.append(np.array(operation(*(numbers[at] for at in operands))))
        values = np.empty((self._outputs, N))
        work = np.empty((self._slots, min(CHUNK, N)))
        for start in range(0, N, CHUNK):
            stop = min(start + CHUNK, N)
            at = [*work[:, : stop - start], *inputs[:, start:stop], *values[:, start:stop], *numbers]
            for operation, operands in self._rows:
                operation(*operands(at))
        return values


def _operations(ca: Any) -> dict[int, tuple[Any, int]]:
    """NumPy function and number of operands for each CasADi operation code."""
    return {
        ca.OP_ADD: (np.add, 2),
        ca.OP_SUB: (np.subtract, 2),
        ca.OP_MUL: (np.multiply, 2),
        ca.OP_TWICE: (np.add, 2),  # CasADi names its one operand once or twice
        ca.OP_NEG: (np.negative, 1),
        ca.OP_SQ: (np.square, 1),
        ca.OP_SIN: (np.sin, 1),
        ca.OP_COS: (np.cos, 1),
        ca.OP_ASSIGN: (np.positive, 1),
    }
