"""The load an arm carries: ten parameters, identified with the arm's own held as they are."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.dynamics.regressor import Regressor, build_regressor
from physident.errors import InputError, NotSolvedError, warn
from physident.estimation.drive_gains.load import every_column, load_regressor, solid_load
from physident.estimation.estimate import Estimate
from physident.estimation.identify import prepare_all
from physident.estimation.least_squares import Solution, least_squares
from physident.estimation.physical.cones import Cones, Matrix
from physident.estimation.uncertainty import BLOCK_PERIODS, FEWEST_BLOCKS, block_labels, correlation_rows, t_quantile
from physident.estimation.weighting import compress
from physident.recordings.checks import refuse_twice
from physident.recordings.recording import Recording
from physident.recordings.signals import Signals
from physident.robots.inertia import PARAMETER_NAMES, PARAMETER_UNITS, about_centre, pseudo_inertia
from physident.validation.scores import with_gains

Array = NDArray[np.float64]
DRAWS = 200  # draws behind the intervals: their ends then wander by a tenth of a standard error
MOST = 0.95  # of them must be solved
MAX_ROUNDS = 50
ABSURD = 1e6  # kg, kg m, kg m^2: rounds that reach it do not settle
SETTLED = 1e-6  # change of the load from one round to the next
FAINT = 0.25  # a joint whose load torque is below this share of its residual says nothing of its own


@dataclass(frozen=True, eq=False)
class Payload:
    """A load on the last link, in that link's frame.

    ``parameters`` (10,) [kg, kg m, kg m^2] in Pinocchio's order, a rigid body's; ``intervals`` (10, 2) hold 95 %, with
    ``mass_interval`` (2,) [kg] and ``centre_interval`` (3, 2) [m]. ``seen_by_joint`` (n, 2) [kg] is the mass each joint
    alone would report and its standard error, NaN where it feels too little. ``sigma`` (n,) [N m|N] is what the load
    leaves unexplained, ``bare`` (n,) what the arm without it does. ``visible``: whether
    the torques show a load at all; ``scale`` says what its mass is proportional to.
    """

    parameters: Array
    intervals: Array
    mass_interval: Array
    centre_interval: Array
    seen_by_joint: Array
    sigma: Array
    bare: Array
    visible: bool
    scale: str
    recordings: tuple[str, ...]

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return float(self.parameters[0])

    @property
    def centre(self) -> Array:
        """Centre of mass (3,) [m] in the last link's frame."""
        return about_centre(self.parameters)[0]

    @property
    def inertia(self) -> Array:
        """Inertia tensor (3, 3) [kg m^2] about the centre of mass, axes along the last link's."""
        return about_centre(self.parameters)[1]

    def as_dict(self) -> dict[str, Any]:
        """The load as JSON can hold it."""
        named = zip(PARAMETER_NAMES, PARAMETER_UNITS, self.parameters, self.intervals, strict=True)
        return {
            "mass_kg": self.mass,
            "mass_interval_kg": self.mass_interval.tolist(),
            "centre_of_mass_m": self.centre.tolist(),
            "centre_of_mass_interval_m": self.centre_interval.tolist(),
            "inertia_about_centre_kg_m2": self.inertia.tolist(),
            "parameters": [
                {"name": name, "unit": unit, "value": float(value), "interval": interval.tolist()}
                for name, unit, value, interval in named
            ],
            "mass_seen_by_joint_kg": [None if np.isnan(m) else [float(m), float(e)] for m, e in self.seen_by_joint],
            "residual_Nm": self.sigma.tolist(),
            "residual_without_load_Nm": self.bare.tolist(),
            "visible": self.visible,
            "scale": self.scale,
            "recordings": list(self.recordings),
        }

    def __repr__(self) -> str:
        low, high = self.mass_interval
        rows = [
            "load on the last link, in that link's frame; intervals hold 95 %",
            f"  mass             {self.mass:9.4g} kg   [{low:.4g}, {high:.4g}]",
        ]
        for axis, value, (a, b) in zip("xyz", self.centre, self.centre_interval, strict=True):
            rows.append(f"  centre of mass {axis} {1000 * value:9.4g} mm   [{1000 * a:.4g}, {1000 * b:.4g}]")
        rows.append(
            "  principal inertias about it "
            + ", ".join(f"{x:.3g}" for x in np.linalg.eigvalsh(self.inertia))
            + " kg m^2"
        )
        rows.append("joint  residual without load  with it [N m]  mass it sees alone [kg]")
        for j, (bare, left, (mass, error)) in enumerate(zip(self.bare, self.sigma, self.seen_by_joint, strict=True), 1):
            alone = "feels too little" if np.isnan(mass) else f"{mass:.4g} ± {error:.2g}"
            rows.append(f"{j:5d}  {bare:21.4g}  {left:13.4g}  {alone:>23}")
        rows.append(self.scale)
        verdict = f"a load of {self.mass:.3g} kg" if self.visible else f"no load is visible; none above {high:.3g} kg"
        return "\n".join([*rows, f"verdict: {verdict}"])


def identify_payload(estimate: Estimate, recordings: Sequence[Recording], seed: int = 0) -> Payload:
    """The load on the last link that explains recordings beyond what the arm's own model does.

    The arm stays as ``estimate`` has it, the load is a rigid body (pseudo-inertia positive semidefinite). Intervals hold
    the residual's autocorrelation, the arm's own uncertainty and the cone; ``seed`` draws them. Raises InputError for
    recordings the arm was fitted to, that do not fit the robot, with efforts that cannot be the arm's, or whose motion does not show all ten parameters;
    NotSolvedError where no optimum can be proved.
    """
    _refuse_fitted(estimate, recordings)
    model = estimate.model
    if not any(effect.name == "rigid_body" for effect in model.effects):
        raise InputError(
            "the model has no rigid_body effect, so no link that could carry a load; identify one with it in --effects"
        )
    gained = [with_gains(recording, estimate.drive_gains) for recording in recordings]
    signals = prepare_all(model.robot, gained, estimate.filter)
    whole, load, free = _free_load(estimate, signals)
    arm = _arm_covariance(estimate, whole, load, free.sigma)
    covariance = free.covariance + arm
    parameters, draws = _on_cone(load, free, covariance, seed)
    centres = draws[:, 1:4] / draws[:, :1]
    return Payload(
        parameters=parameters,
        intervals=_middle(draws),
        mass_interval=_middle(draws[:, :1])[0],
        centre_interval=_middle(centres),
        seen_by_joint=_seen_by_joint(load, parameters, free.sigma),
        sigma=np.sqrt(((load.torque - load.predict(parameters)) ** 2).mean(axis=0)),
        bare=np.sqrt((load.torque**2).mean(axis=0)),
        visible=bool(free.base[0] > t_quantile(free.blocks) * np.sqrt(covariance[0, 0])),
        scale=_scale(gained),
        recordings=tuple(recording.source for recording in recordings),
    )


def _free_load(estimate: Estimate, signals: Sequence[Signals]) -> tuple[Regressor, Regressor, Solution]:
    """The arm's regressor, the load's, and the load without a cone.

    Effects that depend on the torque a joint carries are evaluated with the load on the arm, until it settles.
    """
    model, carried = estimate.model, np.zeros(10)
    bent = [effect.name for effect in model.effects if effect.needs_model]
    for _ in range(MAX_ROUNDS):
        if not np.abs(carried).max() < ABSURD:
            break
        whole = build_regressor(model.robot, model.effects, signals, estimate.filter, model=_carrying(model, carried))
        load = load_regressor(whole, whole.torque - whole.predict(model.theta))
        with warnings.catch_warnings(record=True) as said:  # of the last round alone
            free = least_squares(load, every_column(load.columns), np.zeros(10), "diagonal")
        if np.linalg.norm(free.base - carried) <= SETTLED * np.linalg.norm(free.base) or not bent:
            _refuse_hidden(free)
            for warning in said:
                warn(str(warning.message))
            return whole, load, free
        carried = free.base
    raise NotSolvedError(
        f"the load and what grows with it did not settle in {MAX_ROUNDS} rounds; identify the arm without {', '.join(bent)}"
    )


def _carrying(model: Model, load: Array) -> Model:
    """The model with ten parameters added to its last link."""
    theta = np.array(model.theta)
    theta[[i for i, c in enumerate(model.columns) if c.effect == "rigid_body" and c.joint == model.robot.n]] += load
    return replace(model, theta=theta)


def _refuse_fitted(estimate: Estimate, recordings: Sequence[Recording]) -> None:
    if not recordings:
        raise InputError("no recordings given, expected at least one with the load on the arm")
    fitted = {source.sha256 for source in estimate.sources}
    refuse_twice(recordings)
    for recording in recordings:
        if recording.sha256 in fitted:
            raise InputError(
                f"{recording.source}: the arm's model was fitted to it, so its load is in the model already; expected a recording with a load the model has not seen"
            )


def _refuse_hidden(free: Solution) -> None:
    hidden = [name for name, seen in zip(PARAMETER_NAMES, free.determined, strict=True) if not seen]
    if hidden:
        raise InputError(
            f"the motion does not show {', '.join(hidden)} of the load on its own; expected motion of every joint that turns the load about three axes"
        )


def _arm_covariance(estimate: Estimate, whole: Regressor, load: Regressor, sigma: Array) -> Array:
    """Covariance (10, 10) of the load's parameters that comes from the arm's: an error there is explained as load."""
    normal, mixed = np.zeros((10, 10)), np.zeros((10, estimate.base.r))
    place = np.full(len(whole.columns), -1)
    place[estimate.base.independent] = np.arange(estimate.base.r)
    for arm, own, s in zip(whole.joints, load.joints, sigma, strict=True):
        seen = place[arm.columns] >= 0
        A, Y = own.values / s, arm.values[:, seen] / s
        normal[np.ix_(own.columns, own.columns)] += A.T @ A
        mixed[np.ix_(own.columns, place[arm.columns[seen]])] += A.T @ Y
    transfer = np.linalg.solve(normal, mixed)
    return transfer @ estimate.covariance @ transfer.T


def _on_cone(load: Regressor, free: Solution, covariance: Array, seed: int) -> tuple[Array, Array]:
    """The most likely rigid body, and those of draws around the free estimate: Student's t, as there are few blocks."""
    from physident.estimation.physical.coordinates import Coordinates
    from physident.estimation.physical.prior import NoPrior
    from physident.estimation.physical.program import Program
    from physident.estimation.weighting import Compressed

    base = every_column(load.columns)
    data = compress(load, base, 1 / free.sigma)
    body = Matrix(
        np.stack([pseudo_inertia(unit) for unit in np.eye(10)], axis=-1),
        np.zeros((4, 4)),
        "the load is no rigid body",
        load.columns[0].joint,
    )
    cones = Cones(np.zeros((0, 10)), np.zeros(0), (body,), np.zeros((0, 10)), np.zeros(0), ())
    coordinates = Coordinates.around(solid_load(free.base[0], free.base[1:4]), load.columns)
    program = Program(np.eye(10), coordinates, cones, NoPrior())
    rng = np.random.default_rng(seed)
    freedom = max(1, free.blocks - 1)
    values, vectors = np.linalg.eigh(covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    steps = rng.standard_normal((DRAWS, 10)) / np.sqrt(rng.chisquare(freedom, size=(DRAWS, 1)) / freedom)
    draws = []
    for x in free.base + steps @ root.T:
        with suppress(NotSolvedError):  # one far out may defeat the solver: few enough move no quantile
            draws.append(program.solve(Compressed(data.R, data.R @ x, data.rest, data.rows), 0.0).u)
    if len(draws) < MOST * DRAWS:
        raise NotSolvedError(
            f"{DRAWS - len(draws)} of {DRAWS} draws behind the load's intervals were not solved; record the load for longer"
        )
    best = program.solve(data, 0.0).u
    return coordinates.T @ best, np.array(draws) @ coordinates.T.T


def _middle(draws: Array) -> Array:
    """The middle 95 % (k, 2) of draws (D, k)."""
    return np.quantile(draws, (0.025, 0.975), axis=0).T


def _seen_by_joint(load: Regressor, parameters: Array, sigma: Array) -> Array:
    """Mass (n,) [kg] and standard error by each joint alone, the load's shape held: joints differ where gains do."""
    predicted = load.predict(parameters)
    residual = load.torque - predicted
    length = math.ceil(BLOCK_PERIODS * correlation_rows(load, residual).max())
    labels = block_labels(load.segment, max(1, min(length, len(residual) // FEWEST_BLOCKS)))
    few = math.sqrt((labels[-1] + 1) / labels[-1])
    seen = np.full((predicted.shape[1], 2), np.nan)
    for j, (p, r) in enumerate(zip(predicted.T, load.torque.T, strict=True)):
        if np.sqrt((p**2).mean()) < FAINT * sigma[j]:
            continue
        ratio = float(p @ r) / float(p @ p)
        scores = np.bincount(labels, weights=p * (r - ratio * p))
        seen[j] = parameters[0] * ratio, few * parameters[0] * np.linalg.norm(scores) / float(p @ p)
    return seen


def _scale(recordings: Sequence[Recording]) -> str:
    if all(recording.effort_kind == "torque" for recording in recordings):
        return "the mass is as right as the scale of the measured torque"
    return (
        "mass and torque scale are confounded: torque is current times drive gains, and gains that are all 5 % too high"
        " make the load 5 % too heavy; a load of known mass tells them apart (physident drive-gains)"
    )
