"""The names of joints beside the arm, placed so that they do not cover one another as the session opens."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from physident.graphics import style
from physident.graphics.session.log import duration, rgb

if TYPE_CHECKING:
    import rerun as rr

Array = NDArray[np.float64]
VIEW_FROM = np.array([0.7, -0.95, 0.45])  # direction of the camera: the front right, a little above
WIDTH, HEIGHT = (
    0.1,
    0.075,
)  # of a label, in parts of the arm's reach: those of the viewer's letters in a view of a third
DISTANCES = (0.08, 0.13)  # of a label from its joint, in parts of the reach
DIRECTIONS = 12  # that are tried at each distance
POSES = 60  # of the motion that are looked at
ROUNDS = 4  # in which every label is moved once


def log_joint_names(
    rec: rr.RecordingStream, root: str, clock: Array, positions: Array, upright: Array, marked: Mapping[int, str]
) -> None:
    """Log the name of each joint beside its position (n, N, 3) [m] at instants (N,) [s], under ``root``/names.

    ``upright`` (3, 3) turns the base frame on the screen. The joints of ``marked`` (from 1) have its colours "#RRGGBB".
    """
    import rerun as rr

    joints = len(positions)
    beside = positions + label_offsets(positions, upright)[:, None]
    grey = rgb(style.SESSION_MEASURED)
    columns = rr.Points3D.columns(positions=beside.swapaxes(0, 1).reshape(-1, 3)).partition([joints] * len(clock))
    rec.log(
        f"{root}/names",
        rr.Points3D.from_fields(
            labels=[f"J{j + 1}" for j in range(joints)], show_labels=True, radii=[0.0],
            colors=[rgb(marked[j + 1]) if j + 1 in marked else grey for j in range(joints)],
        ),
        static=True,
    )  # fmt: skip
    rec.send_columns(f"{root}/names", [duration(clock)], columns)


def label_offsets(positions: Array, upright: Array) -> Array:
    """Where each joint's label is, from the joint (n, 3) [m], in the base frame; ``positions`` are (n, N, 3) [m].

    The offsets lie in the plane of the screen and are the same for the whole motion, so that no label jumps. The first
    pose, which is seen on opening, counts as much as all others together.
    """
    across = np.cross([0.0, 0.0, 1.0], VIEW_FROM / np.linalg.norm(VIEW_FROM))
    across /= np.linalg.norm(across)
    up = np.cross(VIEW_FROM / np.linalg.norm(VIEW_FROM), across)
    screen = np.array([across, up]) @ upright  # (2, 3): the base frame as the screen shows it
    reach = max(float(np.ptp(positions.reshape(-1, 3), axis=0).max()), 0.1)
    chosen = np.unique(np.linspace(0, positions.shape[1] - 1, POSES).astype(int))
    at = positions[:, chosen] @ screen.T / reach  # (n, P, 2)
    weight = np.where(chosen == 0, float(len(chosen)), 1.0)
    angles = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    places = np.concatenate([d * np.column_stack([np.cos(angles), np.sin(angles)]) for d in DISTANCES])
    picked = np.tile(places[0], (len(at), 1))
    for _ in range(ROUNDS):
        for j in range(len(at)):
            others = [k for k in range(len(at)) if k != j]
            boxes = np.concatenate([(at + picked[:, None])[others], at])  # other labels, and the joints themselves
            cost = [
                float((_covered(at[j] + place, boxes) + _nearer(place, at[others] - at[j])) @ weight) + 0.1 * k
                for k, place in enumerate(places)
            ]
            picked[j] = places[int(np.argmin(cost))]
    return reach * picked @ screen


def _nearer(place: Array, others: Array) -> Array:
    """How many other joints (K, P, 2) a label at a place (2,) is nearer to than to its own joint, in each pose (P,)."""
    return (np.linalg.norm(others - place, axis=2) < np.linalg.norm(place)).sum(axis=0) / 2


def _covered(label: Array, boxes: Array) -> Array:
    """How many boxes (B, P, 2) a label (P, 2) overlaps in each pose (P,), each by the overlapping share of its sides."""
    apart = np.abs(boxes - label) / [WIDTH, HEIGHT]
    return np.clip(1.0 - apart, 0.0, None).min(axis=2).sum(axis=0) + (apart < 1.0).all(axis=2).sum(axis=0)
