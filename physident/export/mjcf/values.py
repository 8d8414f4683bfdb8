"""The values of a model that MJCF has attributes for: bodies, joints, pairs of joints, gravity."""

from __future__ import annotations

from dataclasses import dataclass
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.effects.effect import Effect
from physident.errors import InputError
from physident.export.held import Held, held_by
from physident.export.urdf import refuse_unphysical
from physident.robots.inertia import about_centre
from physident.robots.robot import Robot

Array = NDArray[np.float64]
NO_BODY = 1e-9  # kg, kg m^2: MuJoCo refuses a moving body without mass
PARTS = ("damping", "dry", "stiffness")  # of a term, in the order of their attributes
ATTRIBUTES = {"damping": "damping", "dry": "frictionloss", "stiffness": "stiffness"}


@dataclass(frozen=True, eq=False, kw_only=True)
class MjcfValues:
    """What MJCF holds of a model of n joints.

    ``links`` (n, 10) are the link parameters with all that moves with each joint, ``armature`` (n,) [kg m^2|kg], ``gravity``
    (3,) [m/s^2] in the base frame; ``armature`` is None for a model without rotors. ``joints`` has for each joint, and ``pairs`` for each pair of joints (from 0) that a
    motor turns together, the values of ``damping``, ``frictionloss`` and ``stiffness`` that the model states. ``negative``
    has one line for each value that MuJoCo does not allow and that is zero here. ``held`` is the part of the model.
    """

    links: Array
    armature: Array | None
    gravity: Array
    joints: tuple[dict[str, float], ...]
    pairs: dict[tuple[int, ...], dict[str, float]]
    negative: tuple[str, ...]
    held: Held

    @property
    def stated(self) -> tuple[str, ...]:
        """One line for each thing that the file does not hold as the model does."""
        return (
            *self.held.folded,
            *(f"not expressible in MJCF: {text}" for text in (*self.held.lost, *self.negative)),
            *(f"of the torque measurement, not of the arm: {text}" for text in self.held.measured),
        )


def mjcf_values(model: Model, child_links: tuple[str, ...]) -> MjcfValues:
    """The values of a model for MJCF; ``child_links`` (n,) names the link that each joint moves.

    Raises InputError for a model without rigid bodies and for a link that is not physical, with its name and the condition
    that it violates.
    """
    if not any(effect.name == "rigid_body" for effect in model.effects):
        raise InputError(
            "the model has no rigid_body effect, so there are no bodies to write; identify a model with rigid_body in --effects"
        )
    robot = model.robot
    held = held_by(model, lambda effect, theta: _holds(robot, effect, theta))
    inertia = held.model.added_inertia()
    links = inertia.links.reshape(-1, 10)
    refuse_unphysical(links, child_links, robot.joint_names)
    totals: dict[tuple[int, ...], dict[str, float]] = {}
    for effect, theta in held.model.effect_parameters():
        for term in effect.joint_terms(robot, theta) or ():
            values = totals.setdefault(term.joints, {})
            for part in PARTS:
                if (value := getattr(term, part)) is not None:
                    values[ATTRIBUTES[part]] = values.get(ATTRIBUTES[part], 0.0) + value
    negative = []
    for places, values in totals.items():
        where = " and ".join(f"joint {j + 1} ({robot.joint_names[j]})" for j in places)
        for attribute in [name for name, value in values.items() if value < 0]:
            negative.append(f"{attribute} {values[attribute]:.4g} of {where} is negative; written as 0")
            values[attribute] = 0.0
    armature = inertia.armature.copy() if _states_armature(model) else None
    for j in [] if armature is None else np.flatnonzero(armature < 0):
        assert armature is not None
        negative.append(
            f"armature {armature[j]:.4g} of joint {j + 1} ({robot.joint_names[j]}) is negative; written as 0"
        )
        armature[j] = 0.0
    return MjcfValues(
        links=links,
        armature=armature,
        gravity=np.array(robot.gravity) + inertia.gravity,
        joints=tuple(totals.get((j,), {}) for j in range(robot.n)),
        pairs={places: values for places, values in totals.items() if len(places) > 1},
        negative=tuple(negative),
        held=held,
    )


def _states_armature(model: Model) -> bool:
    parts = [effect.inertia(model.robot, np.ones_like(theta)) for effect, theta in model.effect_parameters()]
    return any(part is not None and bool(part.armature.any()) for part in parts)


def _holds(robot: Robot, effect: Effect, theta: Array) -> bool:
    return effect.inertia(robot, theta) is not None or effect.joint_terms(robot, theta) is not None


def inertial(phi: Array) -> dict[str, str]:
    """Attributes of MJCF's ``<inertial>`` for link parameters (10,) in the body's frame."""
    if not phi.any():
        phi = np.array([NO_BODY, 0, 0, 0, NO_BODY, 0, NO_BODY, 0, 0, NO_BODY])
    centre, I = about_centre(phi)  # noqa: E741
    full = (I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2])
    return {"pos": numbers(centre), "mass": numbers([phi[0]]), "fullinertia": numbers(full)}


def numbers(values: object) -> str:
    """Numbers as MJCF writes them, with every digit."""
    return " ".join(repr(float(value) + 0.0) for value in np.ravel(np.asarray(values, dtype=float)))


def element(tag: str, attributes: dict[str, str], open: bool = False) -> str:
    """An XML element with its attributes escaped; only its start tag where it stays ``open``."""
    written = "".join(f" {key}={quoteattr(value)}" for key, value in attributes.items())
    return f"<{tag}{written}{'' if open else '/'}>"
