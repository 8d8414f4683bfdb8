"""Writes an identified model into the robot's URDF."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.effects.effect import Effect
from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.export.held import Held, held_by
from physident.export.urdf_edit import Element, edit_urdf, marked, parse_elements
from physident.files import write_text
from physident.robots.inertia import about_centre, violations
from physident.robots.robot import STANDARD_GRAVITY, Robot

Array = NDArray[np.float64]


@dataclass(frozen=True)
class UrdfExport:
    """The URDF ``text`` of an identified model, and what URDF cannot express of it.

    ``links`` (n,) names the link that carries the identified inertia of each joint; ``merged`` (n,) names the links fixed
    to it, whose inertia is now included in that link. ``folded`` has one line for each effect that was written as
    another one, ``inexpressible`` one for each part of the model that URDF cannot express, and ``held`` (see ``Held``) is
    the part that the file expresses.
    """

    text: str
    links: tuple[str, ...]
    merged: tuple[tuple[str, ...], ...]
    folded: tuple[str, ...]
    inexpressible: tuple[str, ...]
    held: Held

    def __repr__(self) -> str:
        rows = ["joint  link with the identified inertia   links fixed to it, now without inertia"]
        for number, (link, others) in enumerate(zip(self.links, self.merged, strict=True), 1):
            rows.append(f"{number:5d}  {link:<34}  {', '.join(others) or '-'}")
        rows += list(self.folded)
        rows += [f"not expressible in URDF: {text}" for text in self.inexpressible]
        return "\n".join(rows)


def export_urdf(model: Model | Estimate, path: str | Path) -> UrdfExport:
    """Write the links, joint damping and friction of a model or an estimate into its robot's URDF; the rest is kept.

    Raises InputError like ``urdf_of``, and for a path that cannot be written.
    """
    result = urdf_of(model.model if isinstance(model, Estimate) else model)
    write_text(path, result.text)
    return result


def urdf_of(model: Model) -> UrdfExport:
    """The model as URDF: the inertia of all links that move with a joint goes to that joint's child link.

    The other links fixed to that child link lose their ``<inertial>``. Links fixed to the base keep theirs, because no
    joint torque depends on it. Raises InputError for a link that is not physical, with its name and the condition that it
    violates, and for a model without rigid bodies.
    """
    robot = model.robot
    if not any(effect.name == "rigid_body" for effect in model.effects):
        raise InputError(
            "the model has no rigid_body effect, so there are no links to write; identify a model with rigid_body in --effects"
        )
    root = parse_elements(robot.urdf)
    child, fixed_together = fixed_links(root)
    parameters = model.added_inertia().links.reshape(robot.n, 10)
    links = tuple(child[name] for name in robot.joint_names)
    refuse_unphysical(parameters, links, robot.joint_names)
    inertials: dict[str, str | None] = {}
    merged = []
    for link, phi in zip(links, parameters, strict=True):
        others = [other for other in fixed_together[link] if other != link]
        inertials |= dict.fromkeys(others) | {link: _inertial(phi) if phi.any() else None}
        merged.append(tuple(other for other in others if _has_inertial(root, other)))
    held = held_by(model, lambda effect, theta: _holds(robot, effect, theta))
    dynamics, negative = _dynamics(held.model)
    text = marked(edit_urdf(robot.urdf, inertials, dynamics))
    inexpressible = (*held.lost, *held.measured, *_gravity(robot), *negative)
    return UrdfExport(text, links, tuple(merged), held.folded, inexpressible, held)


def _holds(robot: Robot, effect: Effect, theta: Array) -> bool:
    """Whether URDF holds an effect: bodies, and the damping and dry friction of single joints."""
    if (added := effect.inertia(robot, theta)) is not None:
        return not added.armature.any() and not any(added.gravity)
    terms = effect.joint_terms(robot, theta)
    return terms is not None and all(len(term.joints) == 1 and term.stiffness is None for term in terms)


def fixed_links(root: Element) -> tuple[dict[str, str], dict[str, list[str]]]:
    """The child link of each moving joint, and for each such link all links that are fixed to it, itself included."""
    parent_of = {}
    child = {}
    for joint in root.find_all("joint"):
        parent, below = (joint.find_all(end)[0].attributes["link"] for end in ("parent", "child"))
        if joint.attributes.get("type") == "fixed":
            parent_of[below] = parent
        else:
            child[joint.attributes["name"]] = below
    fixed_together: dict[str, list[str]] = {link: [] for link in child.values()}
    for link in (element.attributes["name"] for element in root.find_all("link")):
        top = link
        while top in parent_of:
            top = parent_of[top]
        if top in fixed_together:
            fixed_together[top].append(link)
    return child, fixed_together


def _has_inertial(root: Element, name: str) -> bool:
    return any(link.attributes["name"] == name and link.find_all("inertial") for link in root.find_all("link"))


def refuse_unphysical(parameters: Array, links: tuple[str, ...], joints: tuple[str, ...]) -> None:
    """Raises InputError, naming them, for link parameters (n, 10) that no rigid body has; a link may have no mass at all."""
    unphysical = [
        f"link {i} ({link}, moved by {joint}): {_violated_condition(phi)}"
        for i, (phi, link, joint) in enumerate(zip(parameters, links, joints, strict=True), 1)
        if phi.any() and (violations(phi) or phi[0] <= 0)
    ]
    if unphysical:
        raise InputError(
            f"links that are not physical: {'; '.join(unphysical)}. Torques determine only sums of such parameters; identify with --method physical"
        )


def _violated_condition(phi: Array) -> str:
    """The condition that a link violates, in a few words: several links share one line."""
    if phi[0] <= 0:
        return f"mass {phi[0]:.3g} kg is not positive"
    small, middle, large = np.linalg.eigvalsh(about_centre(phi)[1])
    if small < 0:
        return f"principal inertia {small:.3g} kg m^2 is negative"
    return f"principal inertia {large:.3g} exceeds the triangle sum {small + middle:.3g} kg m^2"


def _inertial(phi: Array) -> str:
    """The ``<inertial>`` element of ten link parameters: about the centre of mass, axes along the link's."""
    m = phi[0]
    c, I = about_centre(phi)  # noqa: E741
    values = {"ixx": I[0, 0], "ixy": I[0, 1], "ixz": I[0, 2], "iyy": I[1, 1], "iyz": I[1, 2], "izz": I[2, 2]}
    tensor = " ".join(f'{key}="{_number(value)}"' for key, value in values.items())
    return (
        f'<inertial>\n  <origin xyz="{" ".join(map(_number, c))}" rpy="0 0 0"/>\n  <mass value="{_number(m)}"/>\n'
        f"  <inertia {tensor}/>\n</inertial>"
    )


def _number(value: float) -> str:
    return repr(float(value) + 0.0)


def _dynamics(model: Model) -> tuple[dict[str, dict[str, str]], list[str]]:
    """Attributes of each joint's ``<dynamics>``, and one line for each value that URDF does not allow."""
    totals: dict[tuple[str, str], float] = {}
    for effect, theta in model.effect_parameters():
        for term in effect.joint_terms(model.robot, theta) or ():
            joint = model.robot.joint_names[term.joints[0]]
            for attribute, value in (("damping", term.damping), ("friction", term.dry)):
                if value is not None:
                    totals[joint, attribute] = totals.get((joint, attribute), 0.0) + value
    result: dict[str, dict[str, str]] = {}
    negative = []
    for (joint, attribute), value in totals.items():
        if value < 0:
            number = model.robot.joint_names.index(joint) + 1
            negative.append(f"{attribute} {value:.4g} of joint {number} ({joint}) is negative; written as 0")
        result.setdefault(joint, {})[attribute] = _number(max(0.0, value))
    return result, negative


def _gravity(robot: Robot) -> list[str]:
    if tuple(robot.gravity) == STANDARD_GRAVITY:
        return []
    return [f"gravity {list(robot.gravity)} m/s^2 in the base frame: set it in the simulator"]
