"""Which parameters of a model no arm can have."""

from __future__ import annotations

from typing import Any

import numpy as np

from physident.robots.inertia import pseudo_inertia

ROUNDING = 1e-6  # of a pseudo-inertia's trace: what solvers leave of a constraint that is met


def violations(links: np.ndarray, viscous: np.ndarray, dry: np.ndarray) -> dict[str, Any]:
    """Joints, from 1, whose link has a negative mass or a pseudo-inertia that is not positive semidefinite, or whose friction
    drives the motion; from link parameters (10 n,) and coefficients (n,) [N m s/rad, N m]."""
    each = links.reshape(-1, 10)
    impossible = [k for k, link in enumerate(each, 1) if not possible(link)]
    return {
        "mass": (np.flatnonzero(each[:, 0] < 0) + 1).tolist(),
        "links": impossible,
        "viscous": (np.flatnonzero(viscous < -ROUNDING) + 1).tolist(),
        "dry": (np.flatnonzero(dry < -ROUNDING) + 1).tolist(),
        "of": len(each),
    }


def possible(link: np.ndarray) -> bool:
    """Whether some distribution of mass has these link parameters (10,); this includes the triangle inequalities of inertia."""
    values = np.linalg.eigvalsh(pseudo_inertia(link))
    return bool(values[0] >= -ROUNDING * max(abs(values).sum(), ROUNDING))
