"""Six arms by their tables: what a workshop, a laboratory or a desk has."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from studies.open_world_second.description import Segment, Triple

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
MINUS_Y, MINUS_Z = (0.0, -1.0, 0.0), (0.0, 0.0, -1.0)


@dataclass(frozen=True)
class Design:
    """An arm's segments, its flange [m] in the last one's frame, and the range of its control bandwidth [rad/s]."""

    segments: tuple[Segment, ...]
    flange: Triple
    bandwidth: tuple[float, float]


def _arm(*rows: dict[str, Any], flange: Triple, bandwidth: tuple[float, float]) -> Design:
    return Design(tuple(Segment(**row) for row in rows), flange, bandwidth)


def _row(at: Triple, axis: Triple, body: tuple[float, Triple, Triple], bounds: tuple[float, ...], **more: Any) -> Any:
    """One segment: ``body`` is mass, centre and box; ``bounds`` are low, high, speed and acceleration."""
    mass, centre, box = body
    low, high, speed, acceleration = bounds
    return {"at": at, "axis": axis, "mass": mass, "centre": centre, "box": box, "low": low, "high": high} | (
        {"speed": speed, "acceleration": acceleration} | more
    )


# A shoulder far ahead of the column, a bent elbow and a wrist with three crossing axes, standing upright at zero.
FOUNDRY = _arm(
    _row((0, 0, 0.2), Z, (26, (0.04, -0.015, 0.12), (0.28, 0.3, 0.32)), (-2.6, 2.6, 2.0, 5), askew=(0.1, 0.2, 0.3)),
    _row((0.16, 0, 0.25), Y, (17, (-0.01, 0.07, 0.24), (0.16, 0.14, 0.6)), (-1.0, 1.6, 1.8, 4), askew=(0.08, -0.1, 0)),
    _row((0, 0, 0.56), Y, (12, (0.05, 0.03, 0.05), (0.24, 0.18, 0.2)), (-1.2, 1.9, 2.0, 6), askew=(0.3, 0.2, -0.2)),
    _row((0.12, 0, 0.03), X, (6.5, (0.2, 0.012, -0.008), (0.42, 0.12, 0.14)), (-2.8, 2.8, 3, 9), askew=(0.4, 0, 0.1)),
    _row((0.4, 0, 0), Y, (2.1, (0.03, 0.006, 0.004), (0.13, 0.08, 0.1)), (-1.9, 1.9, 3, 10), askew=(0.2, 0.5, 0)),
    _row((0.09, 0, 0), X, (0.9, (0.03, 0.012, -0.014), (0.06, 0.12, 0.07)), (-3, 3, 4, 14), askew=(0.6, 0.1, 0.2)),
    flange=(0.1, 0, 0),
    bandwidth=(50, 110),
)

# Seven light joints; shoulder, elbow and wrist each stand beside the axis before them.
HARBOUR = _arm(
    _row((0, 0, 0.14), Z, (4.2, (0.03, -0.02, 0.11), (0.16, 0.15, 0.24)), (-2.6, 2.6, 1.9, 7), askew=(0.2, 0.3, 0)),
    _row((0.08, 0, 0.2), Y, (3.6, (0.004, 0.05, 0.09), (0.13, 0.14, 0.25)), (-1.6, 1.6, 1.8, 6), askew=(0.1, 0.1, 0.5)),
    _row((0, 0.03, 0.21), Z, (3.1, (0.04, 0.01, 0.1), (0.14, 0.12, 0.24)), (-2.6, 2.6, 2, 8), askew=(0, 0.35, 0.1)),
    _row((0.06, 0, 0.19), MINUS_Y, (2.7, (-0.03, 0.04, 0.08), (0.13, 0.12, 0.2)), (0, 2.5, 2, 8), askew=(0.3, 0, 0.2)),
    _row((-0.06, 0, 0.2), Z, (2.4, (0.01, 0.04, 0.09), (0.1, 0.13, 0.24)), (-2.6, 2.6, 2.4, 10), askew=(0.25, 0.1, 0)),
    _row((0, 0, 0.19), Y, (1.4, (0.05, 0.006, 0.01), (0.12, 0.09, 0.1)), (-1.7, 1.7, 2.6, 11), askew=(0.1, 0.4, 0.3)),
    _row((0.08, 0, 0.09), MINUS_Z, (0.8, (0.012, 0.015, -0.03), (0.1, 0.06, 0.08)), (-2.8, 2.8, 2.6, 12)),
    flange=(0, 0.02, 0.11),
    bandwidth=(45, 100),
)

# Two horizontal links, a quill that slides downwards, and a gripper that turns beside its axis.
PACKER = _arm(
    _row((0, 0, 0.32), Z, (9, (0.17, 0.012, 0.03), (0.4, 0.16, 0.12)), (-2.2, 2.2, 3.5, 14), askew=(0, 0.1, 0.05)),
    _row((0.35, 0, 0.06), Z, (6, (0.12, -0.01, 0.05), (0.34, 0.14, 0.16)), (-2.3, 2.3, 4, 18), askew=(0.05, 0, 0.1)),
    _row((0.28, 0, 0.02), MINUS_Z, (1.6, (0, 0.004, -0.1), (0.04, 0.03, 0.4)), (0, 0.18, 0.6, 5), kind="prismatic"),
    _row((0, 0, -0.18), Z, (0.9, (0.035, 0.012, -0.03), (0.14, 0.07, 0.06)), (-3, 3, 6, 40), askew=(0.2, 0.2, 0.3)),
    flange=(0.02, 0, -0.07),
    bandwidth=(60, 120),
)

# A boom with a lance: the tool is longer than either link and hangs to the side.
PAINTER = _arm(
    _row((0, 0, 0.5), Z, (22, (0.02, 0.03, 0.1), (0.3, 0.3, 0.35)), (-2.4, 2.4, 1.4, 3), turned=(0, 0, 0.4)),
    _row((0.1, 0.06, 0.18), Y, (11, (0.01, 0.05, 0.28), (0.12, 0.12, 0.66)), (-0.9, 1.5, 1.2, 3), askew=(0.05, 0.1, 0)),
    _row((0, 0, 0.62), Y, (8.5, (0.05, -0.08, 0.38), (0.1, 0.14, 1.1)), (0.2, 2.3, 1.4, 4), askew=(0.15, 0.1, 0)),
    flange=(0.04, -0.16, 1.15),
    bandwidth=(35, 80),
)

# Two links that swing in one upright plane beside a wall.
SWING = _arm(
    _row((0, 0.1, 0.9), Y, (5.5, (0.015, 0.04, -0.2), (0.12, 0.1, 0.5)), (-2.3, 2.3, 3, 9), turned=(0, 0, 0.3)),
    _row((0, 0.06, -0.45), Y, (3.2, (-0.02, 0.01, -0.17), (0.1, 0.08, 0.42)), (-2.4, 2.4, 4, 16), askew=(0.1, 0.2, 0)),
    flange=(0, 0, -0.4),
    bandwidth=(40, 90),
)

# A small arm of plastic and servos, with much friction for its weight.
DESK = _arm(
    _row((0, 0, 0.05), Z, (0.55, (0.008, -0.004, 0.03), (0.07, 0.07, 0.06)), (-2.5, 2.5, 2, 9), askew=(0.1, 0.2, 0.1)),
    _row((0.012, 0, 0.06), Y, (0.42, (0.01, 0.01, 0.07), (0.05, 0.05, 0.18)), (-1.4, 1.4, 2, 8), askew=(0.1, 0.1, 0)),
    _row((0, 0, 0.17), Y, (0.3, (0.012, -0.006, 0.06), (0.04, 0.05, 0.16)), (-1.7, 1.7, 2.4, 10), askew=(0, 0.2, 0.1)),
    _row((0, 0, 0.15), MINUS_Y, (0.2, (0.01, 0.008, 0.03), (0.05, 0.04, 0.08)), (-1.8, 1.8, 3, 14)),
    _row((0, 0, 0.06), Z, (0.16, (0.014, 0.006, 0.04), (0.07, 0.03, 0.08)), (-2.6, 2.6, 3, 18), askew=(0.3, 0.1, 0)),
    flange=(0, 0, 0.1),
    bandwidth=(40, 90),
)

DESIGNS: dict[str, Design] = {
    "foundry": FOUNDRY,
    "harbour": HARBOUR,
    "packer": PACKER,
    "painter": PAINTER,
    "swing": SWING,
    "desk": DESK,
}
