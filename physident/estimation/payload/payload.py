"""A load on the last link, as it was identified."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.robots.inertia import PARAMETER_NAMES, PARAMETER_UNITS, about_centre

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, kw_only=True)
class Payload:
    """A load on the last link, in that link's frame.

    ``parameters`` (10,) [kg, kg m, kg m^2] of a rigid body in Pinocchio's order; ``intervals`` (10, 2), ``mass_interval``
    (2,) [kg] and ``centre_interval`` (3, 2) [m] cover 95 %. ``seen_by_joint`` (n, 2) [kg]: mass by each joint alone and
    its standard error, NaN where the load's torque is too small. ``sigma`` (n,) [N m|N]: RMS residual with the load,
    ``sigma_without_load`` (n,) without it. ``visible``: whether the torques show a load at all; ``scale`` says what the
    mass is proportional to.
    """

    parameters: Array
    intervals: Array
    mass_interval: Array
    centre_interval: Array
    seen_by_joint: Array
    sigma: Array
    sigma_without_load: Array
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
        """The load as plain numbers and texts for JSON."""
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
            "residual_without_load_Nm": self.sigma_without_load.tolist(),
            "visible": self.visible,
            "scale": self.scale,
            "recordings": list(self.recordings),
        }

    def __repr__(self) -> str:
        low, high = self.mass_interval
        rows = [
            "load on the last link, in that link's frame; intervals cover 95 %",
            f"  mass             {self.mass:9.4g} kg   [{low:.4g}, {high:.4g}]",
        ]
        for axis, value, (a, b) in zip("xyz", self.centre, self.centre_interval, strict=True):
            rows.append(f"  centre of mass {axis} {1000 * value:9.4g} mm   [{1000 * a:.4g}, {1000 * b:.4g}]")
        rows.append(
            "  principal inertias about it "
            + ", ".join(f"{x:.3g}" for x in np.linalg.eigvalsh(self.inertia))
            + " kg m^2"
        )
        rows.append("joint  residual without load  with it [N m]  mass by it alone [kg]")
        for j, (without, with_load, (mass, error)) in enumerate(
            zip(self.sigma_without_load, self.sigma, self.seen_by_joint, strict=True), 1
        ):
            alone = "torque too small" if np.isnan(mass) else f"{mass:.4g} ± {error:.2g}"
            rows.append(f"{j:5d}  {without:21.4g}  {with_load:13.4g}  {alone:>23}")
        rows.append(self.scale)
        verdict = f"a load of {self.mass:.3g} kg" if self.visible else f"no load is visible; none above {high:.3g} kg"
        return "\n".join([*rows, f"verdict: {verdict}"])
