"""What an engineer writes for one arm with pinocchio, numpy, scipy and cvxpy: `plain.py TASK ols|wls|sdp CUTOFF OUT`.

Positions pass a zero-phase Butterworth filter and are differentiated twice; torque and regressor pass another one, at the
cutoff, and are decimated. Base parameters come from a pivoted QR. The semidefinite program has all link parameters, each
pseudo-inertia positive semidefinite, no negative friction or rotor inertia, and a weak pull towards the description.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cvxpy as cp
import numpy as np
import pandas as pd
import pinocchio as pin
from program import Call, Stages, columns
from scipy.linalg import qr
from scipy.signal import butter, sosfiltfilt

Array = np.ndarray
SMOOTH = 2.0  # positions are filtered at this many times the cutoff
ROWS = 5.0  # rows kept per period of the cutoff
TURN = 0.01  # rad/s, width of tanh in dry friction
MOVING, BEFORE = 0.02, 0.2  # rad/s; s
PULL = 1e-6  # weight of the description in the semidefinite program
RANK = 1e-6  # of the largest pivot


def low_pass(x: Array, cutoff: float, rate: float) -> Array:
    return sosfiltfilt(butter(4, cutoff / (rate / 2), output="sos"), x, axis=0)


def motion(path: Path, cutoff: float) -> tuple[Array, ...]:
    """Times (N,), then q, v, a and tau (N, n) on a uniform clock, over the part in which the arm moves."""
    table = pd.read_csv(path)
    t = table["time"].to_numpy()
    rate = 1 / np.median(np.diff(t))
    time = np.arange(t[0], t[-1], 1 / rate)

    def resampled(x: Array) -> Array:
        return np.column_stack([np.interp(time, t, x[:, j]) for j in range(x.shape[1])])

    q = low_pass(resampled(columns(table, "q")), SMOOTH * cutoff, rate)
    v = np.gradient(q, 1 / rate, axis=0)
    a = np.gradient(v, 1 / rate, axis=0)
    tau = columns(table, "tau")
    return time, q, v, a, (resampled(tau) if tau.shape[1] else np.zeros_like(q))


def moving(time: Array, v: Array) -> slice:
    fast = np.flatnonzero(np.abs(v).max(axis=1) > MOVING)
    margin = round(BEFORE / (time[1] - time[0]))
    return slice(max(fast[0] - margin, 0), fast[-1] + margin + 1)


def regressor(model: pin.Model, q: Array, v: Array, a: Array) -> Array:
    """(N, n, p): links, then viscous and dry friction, rotor inertia and offset of each joint."""
    data, n = model.createData(), model.nv
    Y = np.zeros((len(q), n, 14 * n))
    for k in range(len(q)):
        Y[k, :, : 10 * n] = pin.computeJointTorqueRegressor(model, data, q[k], v[k], a[k])
    each = np.arange(n)
    for block, x in enumerate((v, np.tanh(v / TURN), a, np.ones_like(v))):
        Y[:, each, 10 * n + block * n + each] = x
    return Y


def equations(model: pin.Model, run: tuple[Array, ...], cutoff: float) -> tuple[Array, Array]:
    """Filtered and decimated regressor (N, n, p) and torque (N, n) of the moving part."""
    time, q, v, a, tau = run
    rate, rows = 1 / (time[1] - time[0]), moving(time, v)
    Y = regressor(model, q[rows], v[rows], a[rows])
    every = max(1, int(rate / (ROWS * cutoff)))
    return low_pass(Y, cutoff, rate)[::every], low_pass(tau[rows], cutoff, rate)[::every]


def base(Y: Array) -> tuple[Array, Array]:
    """Indices (r,) of independent columns, and the matrix (r, p) from all parameters to base parameters."""
    found: Any = qr(Y, mode="r", pivoting=True)
    R, order = found
    size = np.abs(np.diag(R[: Y.shape[1]]))
    rank = int((size > RANK * size[0]).sum())
    M = np.zeros((rank, Y.shape[1]))
    M[:, order[:rank]] = np.eye(rank)
    M[:, order[rank:]] = np.linalg.solve(R[:rank, :rank], R[:rank, rank:])
    return order[:rank], M


def semidefinite(Y: Array, tau: Array, description: Array, n: int) -> Array:
    """All parameters (p,): physically possible links, no negative friction or rotor inertia."""
    Q, R = np.linalg.qr(Y)
    theta = cp.Variable(Y.shape[1])
    possible: list[Any] = [theta[10 * n : 13 * n] >= 0]
    for link in range(n):
        m, x, y, z, xx, xy, yy, xz, yz, zz = (theta[10 * link + k] for k in range(10))
        half = (xx + yy + zz) / 2
        P = [[half - xx, -xy, -xz, x], [-xy, half - yy, -yz, y], [-xz, -yz, half - zz, z], [x, y, z, m]]
        possible.append(cp.bmat(P) >> 0)
    error = cp.sum_squares(R @ theta - Q.T @ tau)
    cp.Problem(cp.Minimize(error + PULL * cp.sum_squares(theta - description)), possible).solve(solver=cp.CLARABEL)
    assert theta.value is not None, "the semidefinite program was not solved"
    return theta.value


def fit(Y: Array, tau: Array, description: Array, method: str) -> Array:
    """Parameters (p,): base parameters by least squares, the rest as near to the description as they allow; or by SDP."""
    n = Y.shape[1]
    flat, right = Y.reshape(-1, Y.shape[2]), tau.ravel()
    kept, M = base(flat)
    phi = np.linalg.lstsq(flat[:, kept], right, rcond=None)[0]
    if method != "ols":  # each joint's rows divided by its residual
        sigma = np.tile((tau - Y[:, :, kept] @ phi).std(axis=0), len(Y))
        flat, right = flat / sigma[:, None], right / sigma
        phi = np.linalg.lstsq(flat[:, kept], right, rcond=None)[0]
    if method == "sdp":
        return semidefinite(flat, right, description, n)
    return description + np.linalg.pinv(M) @ (phi - M @ description)


def main() -> None:
    call, stages = Call.read(), Stages()
    stages.end("imports")
    model = pin.buildModelFromUrdf(str(call.task / "robot.urdf"))
    n = model.nv
    description = np.concatenate([*(model.inertias[k].toDynamicParameters() for k in range(1, n + 1)), np.zeros(4 * n)])
    runs = [motion(path, call.cutoff) for path in sorted(call.task.glob("train_*.csv"))]
    stages.end("read")
    parts = [equations(model, run, call.cutoff) for run in runs]
    Y, tau = (np.concatenate(side) for side in zip(*parts, strict=True))
    stages.end("regressor")
    theta = fit(Y, tau, description, call.method)
    stages.end("fit")
    time, q, v, a, _ = motion(call.task / "test.csv", call.cutoff)
    torque = regressor(model, q, v, a) @ theta
    stages.end("predict")
    call.answer(stages, time, torque, links=theta[: 10 * n], viscous=theta[10 * n : 11 * n], dry=theta[11 * n : 12 * n])


if __name__ == "__main__":
    main()
