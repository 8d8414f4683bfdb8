"""The shapes of a robot's links as MJCF: for the eye only, without mass and without contacts."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from physident.export.mjcf.values import element, numbers
from physident.graphics.visuals import Visual

READ = (".stl", ".obj")  # formats of meshes that MuJoCo reads
SEEN = {"contype": "0", "conaffinity": "0", "group": "2"}  # drawn, and part of no contact


def assets(
    visuals: Sequence[Visual], folder: Path
) -> tuple[dict[tuple[Path, tuple[float, ...]], dict[str, str]], list[str]]:
    """Attributes of a ``<mesh>`` for each file and scale, with paths from ``folder``; and one line for each unread mesh."""
    files: dict[tuple[Path, tuple[float, ...]], dict[str, str]] = {}
    unread = []
    for visual in visuals:
        if visual.mesh is None or (visual.mesh, visual.size) in files:
            continue
        if visual.mesh.suffix.lower() not in READ:
            unread.append(f"not drawn: mesh {visual.mesh.name}, because MuJoCo reads {' and '.join(READ)} only")
            continue
        path = os.path.relpath(os.path.abspath(visual.mesh), folder)
        files[visual.mesh, visual.size] = {
            "name": f"{visual.mesh.stem}_{len(files) + 1}",
            "file": path,
            "scale": numbers(visual.size),
        }
    return files, list(dict.fromkeys(unread))


def shapes(
    visuals: Sequence[Visual], joint: int, files: dict[tuple[Path, tuple[float, ...]], dict[str, str]]
) -> list[str]:
    """One ``<geom>`` for each visual of a joint (from 0, -1 the base) that MuJoCo can draw."""
    lines = []
    for visual in visuals:
        if visual.joint != joint or (visual.mesh is not None and (visual.mesh, visual.size) not in files):
            continue
        lines.append(element("geom", _geom(visual, files) | SEEN))
    return lines


def _geom(visual: Visual, files: dict[tuple[Path, tuple[float, ...]], dict[str, str]]) -> dict[str, str]:
    from scipy.spatial.transform import Rotation

    turn = numbers(np.roll(Rotation.from_matrix(visual.rotation).as_quat(), 1))
    place = {"pos": numbers(visual.translation), "quat": turn}
    if visual.mesh is not None:
        return {"type": "mesh", "mesh": files[visual.mesh, visual.size]["name"], **place}
    if visual.kind == "box":
        return {"type": "box", "size": numbers(np.array(visual.size) / 2), **place}
    if visual.kind == "sphere":
        return {"type": "sphere", "size": numbers(visual.size), **place}
    radius, length = visual.size
    if visual.kind == "capsule":  # ours starts at the centre of its first end, MuJoCo's is centred
        place["pos"] = numbers(visual.translation + visual.rotation @ [0.0, 0.0, length / 2])
    return {"type": visual.kind, "size": numbers([radius, max(length / 2, 1e-6)]), **place}
