"""Collision geometry of a robot's links, and capsules around it, whose distances are smooth enough for a search."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.robots.robot import Robot

Array = NDArray[np.float64]
INSIDE = 1e-9  # m: tolerance of "inside"


@dataclass(frozen=True, eq=False)
class Capsule:
    """All points within ``radius`` [m] of the line from ``start`` to ``end`` (3,) [m].

    Both are in the frame of joint ``link`` (from 1), or of the base (0). ``geometries`` are the indices of the collision
    geometry objects inside.
    """

    link: int
    start: Array
    end: Array
    radius: float
    geometries: tuple[int, ...] = ()


def collision_geometry(robot: Robot, meshes: str | Path | None = None) -> Any:
    """Pinocchio's geometry model of the URDF's collision elements; ``meshes`` is the folder of its packages.

    Raises InputError where a mesh cannot be read, naming it, or where no link has a collision element.
    """
    import pinocchio as pin

    folders = [] if meshes is None else [str(meshes)]
    try:
        geometry = pin.buildGeomFromUrdfString(robot.pinocchio, robot.urdf, pin.GeometryType.COLLISION, None, folders)
    except Exception as error:  # the binding raises several kinds for one cause
        reason = (str(error).splitlines() or [type(error).__name__])[0][:200]
        raise InputError(
            f"{robot.source}: the collision geometry cannot be read ({reason}); expected its meshes in the folder given with --meshes, or --limits joint"
        ) from None
    if not len(geometry.geometryObjects):
        raise InputError(
            f"{robot.source}: no link has a collision element, so self-collision cannot be checked; expected collision elements in the URDF, or --limits joint"
        )
    return geometry


def capsules_of(geometry: Any) -> tuple[Capsule, ...]:
    """Capsules around the collision geometry; a capsule inside another one of the same link is merged into it.

    Spheres, cylinders and capsules keep their axis. A box gets a capsule along its longest axis, a mesh along its longest
    principal axis.
    """
    found = [replace(_around(one), geometries=(k,)) for k, one in enumerate(geometry.geometryObjects)]
    kept: list[Capsule] = []
    for capsule in sorted(found, key=lambda c: -float(np.linalg.norm(c.end - c.start))):
        outer = next((k for k, other in enumerate(kept) if _contains(other, capsule)), None)
        if outer is None:
            kept.append(capsule)
        else:
            kept[outer] = replace(kept[outer], geometries=kept[outer].geometries + capsule.geometries)
    return tuple(sorted(kept, key=lambda c: c.link))


def _around(one: Any) -> Capsule:
    """The capsule around one geometry object, in its joint's frame."""
    shape, place = one.geometry, one.placement
    kind = type(shape).__name__
    if kind == "Sphere":
        return Capsule(int(one.parentJoint), place.translation.copy(), place.translation.copy(), float(shape.radius))
    if kind in ("Cylinder", "Capsule"):
        half = np.array([0.0, 0.0, float(shape.halfLength)])
        return Capsule(int(one.parentJoint), place.act(-half), place.act(half), float(shape.radius))
    if kind == "Box":
        signs = np.array(np.meshgrid(*[(-1.0, 1.0)] * 3)).reshape(3, -1).T
        points = signs * np.asarray(shape.halfSide)
    else:
        points = np.asarray(shape.vertices()).reshape(-1, 3)
    start, end, radius = bounding_capsule(points)
    return Capsule(int(one.parentJoint), place.act(start), place.act(end), radius)


def bounding_capsule(points: Array) -> tuple[Array, Array, float]:
    """Start, end (3,) and radius of a capsule that contains points (N, 3), along their longest principal axis."""
    centre = (points.max(axis=0) + points.min(axis=0)) / 2
    axis = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][0]
    along = (points - centre) @ axis
    across = points - centre - along[:, None] * axis
    middle = (across.max(axis=0) + across.min(axis=0)) / 2
    middle -= (middle @ axis) * axis
    aside = np.linalg.norm(across - middle, axis=1)
    radius = float(aside.max())
    # a point nearer to the axis may lie in the spherical end
    slack = np.sqrt(np.maximum(radius**2 - aside**2, 0.0))
    low, high = float((along + slack).min()), float((along - slack).max())
    low, high = (low, high) if low < high else ((low + high) / 2,) * 2
    base = centre + middle
    return base + low * axis, base + high * axis, radius


def _contains(outer: Capsule, inner: Capsule) -> bool:
    """Whether one capsule of a link contains another of the same link."""
    if outer.link != inner.link:
        return False
    axis = outer.end - outer.start
    size = float(axis @ axis)
    for point in (inner.start, inner.end):
        share = float(np.clip((point - outer.start) @ axis / size, 0, 1)) if size > 0 else 0.0
        if np.linalg.norm(point - outer.start - share * axis) + inner.radius > outer.radius + INSIDE:
            return False
    return True


def nearest_points(p: Array, d: Array, other_p: Array, other_d: Array) -> tuple[Array, Array]:
    """Nearest points of two line segments: s, t (...) from 0 to 1, of p + s d and other_p + t other_d (..., 3).

    Source: Ericson, "Real-Time Collision Detection" (2005), sec. 5.1.9.
    """
    r = p - other_p
    a, e, b = (np.sum(x * y, axis=-1) for x, y in ((d, d), (other_d, other_d), (d, other_d)))
    c, f = np.sum(d * r, axis=-1), np.sum(other_d * r, axis=-1)
    span = a * e - b * b
    tiny = 1e-12
    a_safe, e_safe = np.where(a > tiny, a, 1.0), np.where(e > tiny, e, 1.0)
    parallel = span <= tiny * np.maximum(a * e, tiny)
    s = np.where(parallel, 0.0, np.clip((b * f - c * e) / np.where(parallel, 1.0, span), 0, 1))
    t = np.where(e > tiny, (b * s + f) / e_safe, 0.0)
    t = np.clip(t, 0, 1)
    s = np.where(a > tiny, np.clip((b * t - c) / a_safe, 0, 1), 0.0)
    return s, t
