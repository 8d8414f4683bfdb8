"""A picture of the arm: its links as lines, its joints as numbered circles, those of each cause in its colour."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from physident.diagnosis.result.findings import Finding
from physident.diagnosis.result.record import DiagnosisRecord
from physident.diagnosis.result.wording import cause, listed
from physident.graphics.scene import link_poses, upright
from physident.graphics.style import effect_colour
from physident.report.chart import swatch
from physident.report.markup import tag
from physident.report.reread import Reread
from physident.robots.robot import Robot

Array = NDArray[np.float64]
SIZE, MARGIN, RADIUS = 400.0, 46.0, 15.0  # units of the drawing
POSES, VIEWS = 40, 12  # that are tried, so that no joint hides another
SLOPE = np.deg2rad(20.0)  # of the look down on the arm
PALE = "#ffffff"


def arm_picture(c: DiagnosisRecord, recordings: Sequence[Reread]) -> Markup:
    """The arm in a pose of its recordings, or in one within its limits where none was read again."""
    robot = c.model.robot
    points = _clearest(robot, _poses(robot, recordings))
    (left, top), (right, bottom) = points.min(axis=0) - MARGIN, points.max(axis=0) + MARGIN
    causes = list(c.causes)
    parents = [joint.parent for joint in robot.joints]
    links = [_line(points[parent + 1], points[j + 1]) for j, parent in enumerate(parents)]
    links.append(_line(points[-2], points[-1]))
    foot = tag("rect", x=points[0][0] - 26, y=points[0][1], width=52, height=8, class_="foot")
    marked = {j: [f for f in causes if j in f.joints] for j in range(1, robot.n + 1)}
    tool = _rings(points[-1], [f for f in causes if not f.joints]) or [_circle(points[-1], RADIUS / 2, "#c8c8c8")]
    joints = [
        part
        for group in _places(points[1:-1])
        for part in _joint(group, points[group[0]], [f for f in causes if any(f in marked[j] for j in group)])
    ]
    drawing = tag(
        "svg",
        foot,
        *links,
        *tool,
        *joints,
        viewBox=f"{left:.0f} {top:.0f} {right - left:.0f} {bottom - top:.0f}",
        role="img",
        aria_label=_words(causes),
    )
    names = [tag("p", swatch(effect_colour(f.effect)), cause(f.effect, f.joints), class_="legend") for f in causes]
    return tag("div", drawing, *names, class_="arm")


def _words(causes: Sequence[Finding]) -> str:
    return f"the arm, marked: {listed([cause(f.effect, f.joints) for f in causes])}" if causes else "the arm"


def _poses(robot: Robot, recordings: Sequence[Reread]) -> Array:
    """Positions (P, n) to choose from: some of the first recording, or random ones in the middle of the limits."""
    for one in recordings:
        if one.recording is not None:
            return one.recording.q[np.linspace(0, len(one.recording.q) - 1, POSES).astype(int)]
    half = np.minimum(np.nan_to_num(np.subtract(robot.upper, robot.lower), posinf=np.pi) / 4, 1.2)
    middle = np.nan_to_num(np.add(robot.upper, robot.lower) / 2)
    return middle + half * np.random.default_rng(0).uniform(-1, 1, size=(POSES, robot.n))


def _clearest(robot: Robot, poses: Array) -> Array:
    """Base, joints and tool (n + 2, 2) in the drawing, in the pose and from the side in which no two circles overlap most."""
    rotations, positions = link_poses(robot, poses)
    tools = positions[-1] + rotations[-1] @ robot.tool
    all_points = np.concatenate([np.zeros_like(tools)[None], positions, tools[None]]).transpose(1, 0, 2)
    up = upright(robot.gravity)
    seen = [
        _fitted(points @ up.T @ _view(angle))
        for points in all_points
        for angle in np.linspace(0, 2 * np.pi, VIEWS, endpoint=False)
    ]
    return max(seen, key=_clearance)


def _view(angle: float) -> Array:
    """The projection (3, 2) onto right and down of a look from a side."""
    right = [np.cos(angle), np.sin(angle), 0.0]
    down = [-np.sin(SLOPE) * np.sin(angle), np.sin(SLOPE) * np.cos(angle), -np.cos(SLOPE)]
    return np.column_stack([right, down])


def _fitted(points: Array) -> Array:
    low, high = points.min(axis=0), points.max(axis=0)
    scale = (SIZE - 2 * MARGIN) / max(float((high - low).max()), 1e-9)
    return SIZE / 2 + scale * (points - (low + high) / 2)


def _clearance(points: Array) -> float:
    """The smallest distance between two joints, after those that are in one place in space do not count."""
    joints = points[1:-1]
    apart = np.linalg.norm(joints[:, None] - joints[None], axis=2)[np.triu_indices(len(joints), 1)]
    return float(np.sort(np.minimum(apart, 3 * RADIUS)).sum() + apart.min()) if len(apart) else 0.0


def _line(a: Array, b: Array) -> Markup:
    return tag("line", x1=f"{a[0]:.1f}", y1=f"{a[1]:.1f}", x2=f"{b[0]:.1f}", y2=f"{b[1]:.1f}", class_="link")


def _places(joints: Array) -> list[list[int]]:
    """The joints (from 1) by the places (n, 2) of their circles: joints whose circles would cover each other share one."""
    groups: list[list[int]] = []
    for number, at in enumerate(joints, 1):
        near = next((g for g in groups if np.linalg.norm(joints[g[0] - 1] - at) < RADIUS), None)
        groups.append([number]) if near is None else near.append(number)
    return groups


def _joint(numbers: Sequence[int], at: Array, found: Sequence[Finding]) -> list[Markup]:
    """A circle with the number of its joint, or of several, in a ring for each cause on them."""
    circle = _circle(at, RADIUS, PALE if found else "#ececec")
    label = "·".join(map(str, numbers))
    text = tag("text", label, x=f"{at[0]:.1f}", y=f"{at[1] + 5:.1f}", class_="marked" if found else "plain")
    return [*_rings(at, found), circle, text]


def _rings(at: Array, found: Sequence[Finding]) -> list[Markup]:
    return [_circle(at, RADIUS + 6.0 * (len(found) - k), effect_colour(f.effect)) for k, f in enumerate(found)]


def _circle(at: Array, radius: float, colour: str) -> Markup:
    return tag("circle", cx=f"{at[0]:.1f}", cy=f"{at[1]:.1f}", r=f"{radius:g}", fill=colour)
