"""The description of a serial arm as URDF text, written from a table of its segments."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Triple = tuple[float, float, float]
TOOL = "flange"


@dataclass(frozen=True, kw_only=True)
class Segment:
    """A joint and the body it moves.

    ``at`` [m] and ``turned`` (roll, pitch, yaw) [rad] place the joint in the frame before it. The body has ``mass`` [kg],
    its ``centre`` [m] in the joint frame, and the inertia of a box with edges ``box`` [m] that is turned by ``askew`` [rad].
    ``low``, ``high`` [rad or m], ``speed`` [rad/s or m/s] and ``acceleration`` bound the motion.
    """

    at: Triple
    axis: Triple
    mass: float
    centre: Triple
    box: Triple
    low: float
    high: float
    speed: float
    acceleration: float
    turned: Triple = (0.0, 0.0, 0.0)
    askew: Triple = (0.0, 0.0, 0.0)
    kind: Literal["revolute", "prismatic"] = "revolute"

    def scaled(self, length: float, mass: float) -> Segment:
        """The same segment with all lengths times ``length`` and its mass times ``mass``."""
        slides = length if self.kind == "prismatic" else 1.0
        return replace(
            self,
            at=_times(self.at, length),
            centre=_times(self.centre, length),
            box=_times(self.box, length),
            low=self.low * slides,
            high=self.high * slides,
            mass=self.mass * mass,
        )

    def inertia(self) -> Array:
        """Inertia (3, 3) [kg m^2] about the centre of mass, in the axes of the joint frame."""
        square = np.square(self.box)
        principal = self.mass / 12 * (square.sum() - square)
        axes = rotation(self.askew)
        return axes @ np.diag(principal) @ axes.T


def rotation(angles: Triple) -> Array:
    """Rotation matrix (3, 3) of roll, pitch and yaw [rad] about fixed axes."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(angles), np.sin(angles)
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1.0]])
    return about_z @ about_y @ about_x


def urdf(name: str, segments: tuple[Segment, ...], flange: Triple) -> str:
    """URDF text of the segments in a row, with a frame ``flange`` [m] fixed to the last."""
    parts = [f'<?xml version="1.0"?>\n<robot name="{name}">', '  <link name="pedestal"/>']
    before = "pedestal"
    for number, segment in enumerate(segments, 1):
        parts += [_link(number, segment), _joint(number, segment, before)]
        before = f"body_{number}"
    parts.append(f'  <link name="{TOOL}"/>')
    parts.append(
        f'  <joint name="{TOOL}_mount" type="fixed">\n    <parent link="{before}"/>\n    <child link="{TOOL}"/>\n'
        f'    <origin xyz="{_words(flange)}" rpy="0 0 0"/>\n  </joint>\n</robot>\n'
    )
    return "\n".join(parts)


def _link(number: int, segment: Segment) -> str:
    tensor = segment.inertia()
    places = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
    entries = " ".join(f'{key}="{tensor[place]:.9g}"' for key, place in places.items())
    return (
        f'  <link name="body_{number}">\n    <inertial>\n      <origin xyz="{_words(segment.centre)}" rpy="0 0 0"/>\n'
        f'      <mass value="{segment.mass:.9g}"/>\n      <inertia {entries}/>\n    </inertial>\n  </link>'
    )


def _joint(number: int, segment: Segment, before: str) -> str:
    return (
        f'  <joint name="axis_{number}" type="{segment.kind}">\n    <parent link="{before}"/>\n'
        f'    <child link="body_{number}"/>\n'
        f'    <origin xyz="{_words(segment.at)}" rpy="{_words(segment.turned)}"/>\n    <axis xyz="{_words(segment.axis)}"/>\n'
        f'    <limit lower="{segment.low:.9g}" upper="{segment.high:.9g}" velocity="{segment.speed:.9g}" effort="2000"/>\n'
        "  </joint>"
    )


def _words(values: Triple) -> str:
    return " ".join(f"{value:.9g}" for value in values)


def _times(values: Triple, factor: float) -> Triple:
    x, y, z = values
    return (x * factor, y * factor, z * factor)
