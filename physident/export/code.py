"""A model as C code and as a CasADi file: torque, its derivatives and its regressor, without allocation."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from physident.dynamics.model import Model
from physident.estimation.estimate import Estimate
from physident.export.symbolic import SymbolicModel, symbolic_model
from physident.files import write_text
from physident.outputs import write_with

PREFIX = "physident"


def export_c(model: Model | Estimate, path: str | Path) -> None:
    """Write a model or an estimate as C; raises InputError like ``c_of``, and for a path that cannot be written."""
    write_text(path, c_of(model.model if isinstance(model, Estimate) else model))


def export_casadi(model: Model | Estimate, path: str | Path) -> None:
    """Write the model's torque as a CasADi function that ``casadi.Function.load`` reads, for planners.

    Its arguments are q, v, a and, for a model that remembers or depends on the time, z and t. Raises InputError like
    ``c_of``, and for a path that cannot be written.
    """
    function = _functions(symbolic_model(model.model if isinstance(model, Estimate) else model), f"{PREFIX}_torque")[0]
    write_with(path, lambda temporary: function.save(str(temporary)))


def c_of(model: Model) -> str:
    """Source text in C of functions of one instant, whose arguments are arrays of doubles.

    ``physident_torque`` is the torque (n,) [N m|N]; ``physident_derivatives`` its derivatives with respect to q, v and a,
    (n, n) row by row each; ``physident_regressor`` the regressor (n, p), row by row; a model that remembers has
    ``physident_advance``. Raises InputError for effects that are no function of one instant.
    """
    import casadi as ca

    expressions = symbolic_model(model)
    functions = _functions(expressions)
    generator = ca.CodeGenerator(f"{PREFIX}_model", {"with_header": False, "cpp": False, "mex": False})
    for function in functions:
        generator.add(function)
    robot = model.robot
    names = "\n".join(f" *   {number}: {_plain(name)}" for number, name in enumerate(robot.joint_names, 1))
    columns = "\n".join(f" *   {c.name} [{c.unit}]" for c in model.columns)
    head = f"""/* Joint torques of {_plain(robot.name)}, identified with physident.
 *
 * Joints in order:
{names}
 * Columns of the regressor:
{columns}
 *
 * The functions at the end of this file take and give arrays of doubles in SI units, matrices row by row. They allocate
 * nothing, keep no state, and may be called from several threads. Compile with: cc -O2 -c FILE.c
 */
"""
    return head + generator.dump() + "".join(_wrapper(function, robot.n) for function in functions)


def _functions(s: SymbolicModel, name: str = "model_torque") -> list[Any]:
    """CasADi functions of one instant, the torque's called ``name``; matrices are transposed, because CasADi counts down the columns."""
    import casadi as ca

    state = [("q", s.q), ("v", s.v), ("a", s.a)]
    if s.states:
        state.append(("z", s.z))
    if ca.depends_on(s.torque, s.t):
        state.append(("t", s.t))
    names, arguments = [name for name, _ in state], [value for _, value in state]
    derivatives = [ca.densify(ca.jacobian(s.torque, x)).T for x in (s.q, s.v, s.a)]
    functions = [  # C libraries have functions named torque or advance, and a linker may take theirs
        ca.Function(name, arguments, [s.torque], names, ["tau"]),
        ca.Function("model_derivatives", arguments, derivatives, names, ["dtau_dq", "dtau_dv", "dtau_da"]),
        ca.Function("model_regressor", arguments, [s.regressor.T], names, ["Y"]),
    ]
    if s.states:
        functions.append(ca.Function("model_advance", [s.z, s.v, s.dt], [s.advanced], ["z", "v", "dt"], ["z_next"]))
    return functions


def _wrapper(function: Any, n: int) -> str:
    """A C function with named arrays around CasADi's convention of pointers and work space."""
    inputs = [function.name_in(i) for i in range(function.n_in())]
    outputs = [function.name_out(i) for i in range(function.n_out())]
    given = ", ".join(f"const double {name}[{function.nnz_in(i)}]" for i, name in enumerate(inputs))
    made = ", ".join(f"double {name}[{function.nnz_out(i)}]" for i, name in enumerate(outputs))
    name = function.name()
    return f"""
void {PREFIX}_{name.removeprefix("model_")}({given}, {made}) {{
  const double* arg[{max(1, function.sz_arg())}] = {{{", ".join(inputs)}}};
  double* res[{max(1, function.sz_res())}] = {{{", ".join(outputs)}}};
  casadi_int iw[{max(1, function.sz_iw())}];
  double w[{max(1, function.sz_w())}];
  {name}(arg, res, iw, w, 0);
}}
"""


def _plain(name: str) -> str:
    """A name without the characters that could end the comment around it."""
    return re.sub(r"[^\w .:+-]", "_", name, flags=re.ASCII)
