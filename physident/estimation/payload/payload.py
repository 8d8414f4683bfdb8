"""A load on the last link, as it was identified."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.estimation.payload.friction_of_the_day import FrictionOfTheDay
from physident.estimation.payload.gain_change import GainChange
from physident.robots.inertia import PARAMETER_NAMES, PARAMETER_UNITS, about_centre

Array = NDArray[np.float64]
LEFT = (
    2.0  # times the arm's own residual, with friction fitted anew: a healthy arm leaves less on recordings of its own
)
LEVEL = 0.999  # of the test that all joints state one mass
APART = 0.1  # of the mass: errors of joints are themselves estimates, and smaller differences need not matter


@dataclass(frozen=True, eq=False, kw_only=True)
class Payload:
    """A load on the last link, in that link's frame.

    ``parameters`` (10,) [kg, kg m, kg m^2] of a rigid body in Pinocchio's order; ``intervals`` (10, 2), ``mass_interval``
    (2,) [kg], ``centre_interval`` (3, 2) [m] and ``moment_interval`` (3, 2) [kg m^2], of the moments of inertia about
    axes through the centre, cover 95 %. ``seen_by_joint`` (n, 2) [kg]: mass by each joint alone and
    its standard error, NaN where the load's torque is too small. ``sigma`` (n,) [N m|N]: RMS residual with the load,
    ``sigma_without_load`` (n,) without it, ``arm_sigma`` (n,) that of the arm's model on its own recordings, all with rows
    weighted by how well the sign of friction is known in them. ``visible``: whether the torques show a load at all;
    ``scale`` says what the mass is proportional to, ``gain_change`` which drive gain differs most from the model's,
    ``friction_of_the_day`` what mass and residual are with friction fitted anew.
    """

    parameters: Array
    intervals: Array
    mass_interval: Array
    centre_interval: Array
    moment_interval: Array
    seen_by_joint: Array
    sigma: Array
    sigma_without_load: Array
    arm_sigma: Array
    visible: bool
    scale: str
    gain_change: GainChange
    friction_of_the_day: FrictionOfTheDay
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

    @property
    def contradictions(self) -> tuple[str, ...]:
        """Why the intervals cannot be believed, in words; empty where they can."""
        found, day = [], self.friction_of_the_day
        known = self.arm_sigma > 0
        ratio = float(np.sqrt(np.mean((day.sigma[known] / self.arm_sigma[known]) ** 2))) if known.any() else 0.0
        if ratio > LEFT:
            found.append(
                f"with the load, and with new friction, the residual is {ratio:.2g} times that of the arm's model on its own"
                " recordings: the arm, the load or its mounting changed"
            )
        if self.visible and (
            day.mass_interval[0] > self.mass_interval[1] or day.mass_interval[1] < self.mass_interval[0]
        ):
            found.append(
                f"with new friction the mass would be {day.mass:.3g} kg: friction changed since the arm's model was"
                " identified; record the arm without load on the same day"
            )
        if self.visible and (apart := self._apart()) is not None:
            found.append(
                f"joints disagree about the mass beyond their errors (joint {apart[0]} states {apart[1]:.3g} kg, the others {apart[2]:.3g}"
                f" kg): check the drive gain of joint {apart[0]} and the model of the arm"
            )
        if self.gain_change.real:
            found.insert(0, self._gain())
        return tuple(found)

    def _apart(self) -> tuple[int, float, float] | None:
        """The joint (from 1) that is apart from the mean of the others by most of its error, the mass [kg] that it states, and theirs; None
        where none is beyond chance."""
        from scipy.stats import norm

        seen = np.flatnonzero(np.isfinite(self.seen_by_joint).all(axis=1) & (self.seen_by_joint[:, 1] > 0))
        mass, error = self.seen_by_joint[seen].T
        if len(mass) < 2:
            return None
        away = np.abs(mass - np.average(mass, weights=1 / error**2))
        allowed = float(norm.ppf(1 - (1 - LEVEL) / (2 * len(mass))))
        if not ((away > allowed * error) & (away > APART * abs(self.mass))).any():
            return None
        k = int(np.argmax(np.where(away > APART * abs(self.mass), away / error, 0.0)))
        others = np.arange(len(mass)) != k
        return int(seen[k]) + 1, float(mass[k]), float(np.average(mass[others], weights=1 / error[others] ** 2))

    def _gain(self) -> str:
        """The change of a gain in words."""
        change = self.gain_change
        low, high = change.interval
        where = "all joints" if change.joint is None else f"joint {change.joint}"
        return (
            f"the torque of {where} is {1 + change.change:.2f} times (95 % interval {low:.2f} to {high:.2f}) what the arm's own"
            " links need, which no load explains: another drive gain than in the arm's training recordings, or physics that the"
            " model lacks along these motions (physident diagnose)"
        )

    def as_dict(self) -> dict[str, Any]:
        """The load as plain numbers and texts for JSON."""
        named = zip(PARAMETER_NAMES, PARAMETER_UNITS, self.parameters, self.intervals, strict=True)
        return {
            "mass_kg": self.mass,
            "mass_interval_kg": None if self.contradictions else self.mass_interval.tolist(),
            "centre_of_mass_m": self.centre.tolist(),
            "centre_of_mass_interval_m": None if self.contradictions else self.centre_interval.tolist(),
            "inertia_about_centre_kg_m2": self.inertia.tolist(),
            "moments_of_inertia_interval_kg_m2": None if self.contradictions else self.moment_interval.tolist(),
            "parameters": [
                {"name": name, "unit": unit, "value": float(value), "interval": interval.tolist()}
                for name, unit, value, interval in named
            ],
            "mass_seen_by_joint_kg": [None if np.isnan(m) else [float(m), float(e)] for m, e in self.seen_by_joint],
            "residual_Nm": self.sigma.tolist(),
            "residual_without_load_Nm": self.sigma_without_load.tolist(),
            "visible": self.visible,
            "gain_change": asdict(self.gain_change) | {"interval": list(self.gain_change.interval)},
            "warnings": list(self.contradictions),
            "scale": self.scale,
            "recordings": list(self.recordings),
        }

    def __repr__(self) -> str:
        low, high = self.mass_interval
        contradictions = self.contradictions
        title = "intervals withheld" if contradictions else "intervals cover 95 %"

        def interval(a: float, b: float) -> str:
            return "" if contradictions else f"   [{a:.4g}, {b:.4g}]"

        rows = [
            f"load on the last link, in that link's frame; {title}",
            f"  mass             {self.mass:9.4g} kg{interval(low, high)}",
        ]
        for axis, value, (a, b) in zip("xyz", self.centre, self.centre_interval, strict=True):
            rows.append(f"  centre of mass {axis} {1000 * value:9.4g} mm{interval(1000 * a, 1000 * b)}")
        for axis, value, (a, b) in zip("xyz", np.diag(self.inertia), self.moment_interval, strict=True):
            rows.append(f"  inertia about {axis}  {value:9.4g} kg m^2{interval(a, b)}")
        rows.append("joint  residual without load  with it [N m]  mass by it alone [kg]")
        for j, (without, with_load, (mass, error)) in enumerate(
            zip(self.sigma_without_load, self.sigma, self.seen_by_joint, strict=True), 1
        ):
            alone = "torque too small" if np.isnan(mass) else f"{mass:.4g} ± {error:.2g}"
            rows.append(f"{j:5d}  {without:21.4g}  {with_load:13.4g}  {alone:>23}")
        rows.append(self.scale)
        verdict = f"a load of {self.mass:.3g} kg" if self.visible else f"no load is visible; none above {high:.3g} kg"
        if contradictions:
            verdict = f"doubtful: {verdict}, but {'; '.join(contradictions)}"
        return "\n".join([*rows, f"verdict: {verdict}"])
