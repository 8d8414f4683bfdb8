"""MuJoCo models (MJCF) as robots: what the simulator adds to the rigid links is part of the description."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.robots.drives import JointDynamics
from physident.robots.mjcf_urdf import MjcfNames, coupled_joints, urdf_of_mjcf
from physident.robots.urdf import MAX_LINKS
from physident.robots.urdf_numbers import parse_plain

Array = NDArray[np.float64]
LISTED = 3  # names in a message
BODIES = ("body", "composite", "flexcomp")
COPYING = ("replicate", "composite", "flexcomp")  # elements whose count multiplies bodies


@dataclass(frozen=True, kw_only=True)
class MjcfDescription:
    """A MuJoCo model as URDF text, and by joint name: the reference position, the joint's dynamics and the body it moves.

    ``gravity`` (3,) [m/s^2]; ``left_out`` names parts of the simulation that the model of an arm does not contain.
    """

    urdf: str
    gravity: tuple[float, float, float]
    rest: dict[str, float]
    dynamics: dict[str, JointDynamics]
    bodies: dict[str, str]
    left_out: tuple[str, ...]


def read_mjcf(path: str | Path) -> MjcfDescription:
    """The description in a MuJoCo model file, with its includes and meshes, as MuJoCo compiles it.

    Raises InputError where the package mujoco is missing or cannot compile the file, and for more than ``MAX_LINKS`` bodies.
    """
    model = _compiled(path)
    if model.nbody > MAX_LINKS:
        raise InputError(f"{path}: {model.nbody} bodies, expected at most {MAX_LINKS}; leave out all but the arm")
    names = MjcfNames.of(model)
    hinges = [i for i in range(model.njnt) if int(model.jnt_type[i]) >= 2]  # slides and hinges have one coordinate
    if not hinges:
        raise InputError(f"{path}: no hinge or slide joint, expected an arm")
    name = Path(path).stem or "robot"
    x, y, z = (float(value) for value in model.opt.gravity * _enabled(model, "GRAVITY"))
    return MjcfDescription(
        urdf=urdf_of_mjcf(model, names, name, _efforts(model)),
        gravity=(x, y, z),
        rest={names.joints[i]: float(model.qpos0[model.jnt_qposadr[i]]) for i in hinges},
        dynamics={names.joints[i]: _dynamics(model, i) for i in hinges},
        bodies={names.joints[i]: names.bodies[model.jnt_bodyid[i]] for i in hinges},
        left_out=tuple(_left_out(model, names)),
    )


def _compiled(path: str | Path) -> Any:
    try:
        import mujoco
    except ImportError:
        raise InputError(
            f"{path}: a MuJoCo model is read by the package mujoco, which is not installed; expected pip install 'physident[mujoco]'"
        ) from None
    _refuse_copies(path)
    try:
        return mujoco.MjModel.from_xml_path(os.fspath(path))
    except (ValueError, RuntimeError, MemoryError) as error:
        reason = " ".join(str(error).split())[:300]
        raise InputError(
            f"{path}: MuJoCo cannot compile this model ({reason}); expected a model that MuJoCo opens"
        ) from None


def _refuse_copies(path: str | Path) -> None:
    """Raises InputError for elements that make more copies of bodies than an arm has, before MuJoCo makes them."""
    bodies, copies = 0.0, [1.0]
    try:
        for event, element in ElementTree.iterparse(path, events=("start", "end")):
            counts = element.get("count", "1").split() if element.tag in COPYING else []
            if event == "start":
                copies.append(copies[-1] * math.prod(max(1.0, parse_plain(count)) for count in counts))
                bodies += copies[-1] if element.tag in BODIES else 0.0
            else:
                copies.pop()
    except (ElementTree.ParseError, ValueError):
        return  # MuJoCo says what it cannot read
    if bodies > MAX_LINKS:
        raise InputError(f"{path}: makes {bodies:.0f} bodies, expected at most {MAX_LINKS}; leave out all but the arm")


def _dynamics(model: Any, joint: int) -> JointDynamics:
    lead, softness = _friction_softness(model, int(model.jnt_dofadr[joint]))
    dof, position = int(model.jnt_dofadr[joint]), int(model.jnt_qposadr[joint])
    actuators = _actuators(model, joint)
    geared = sum(model.actuator_gear[a][0] ** 2 * _extra(model, "actuator_armature", a) for a in actuators)
    damped = sum(model.actuator_gear[a][0] ** 2 * _extra(model, "actuator_damping", a) for a in actuators)
    return JointDynamics(
        armature=float(model.dof_armature[dof] + geared),
        damping=float(np.ravel(model.dof_damping[dof])[0] + damped) * _enabled(model, "DAMPER"),
        damping_lead=_damping_lead(model),
        friction=float(model.dof_frictionloss[dof]) * _enabled(model, "FRICTIONLOSS"),
        friction_lead=lead,
        friction_width=float(model.dof_frictionloss[dof]) * softness * lead,
        stiffness=float(np.ravel(model.jnt_stiffness[joint])[0]) * _enabled(model, "SPRING"),
        spring_position=float(model.qpos_spring[position]),
        gear=float(model.actuator_gear[actuators[0]][0]) if len(actuators) == 1 else 1.0,
    )


def _damping_lead(model: Any) -> float:
    """Half a step [s] where MuJoCo's integrator takes the damping at the end of a step: its recordings show it so."""
    import mujoco

    integrator = int(model.opt.integrator)
    implicit = _enabled(model, "EULERDAMP") if integrator == int(mujoco.mjtIntegrator.mjINT_EULER) else 1.0
    explicit = integrator == int(mujoco.mjtIntegrator.mjINT_RK4)
    return 0.0 if explicit else implicit * float(model.opt.timestep) / 2


def _friction_softness(model: Any, dof: int) -> tuple[float, float]:
    """The lead 1/b [s] of MuJoCo's dry friction, and the softness R [1/(kg m^2)|1/kg] of the constraint that makes it.

    The force of this constraint, whose reference acceleration is -b v, is (a + b v) / R until it saturates at frictionloss:
    it acts against v + a / b, and has its full size where that exceeds frictionloss R / b.
    """
    impedance, dmax = (float(x) for x in model.dof_solimp[dof][:2])
    time_constant, ratio = (float(x) for x in model.dof_solref[dof])
    if time_constant > 0 and _enabled(model, "REFSAFE"):
        time_constant = max(time_constant, 2 * float(model.opt.timestep))
    # the other format states -stiffness and -damping
    lead = dmax * time_constant / 2 if time_constant > 0 else -1 / ratio if ratio < 0 else 0.0
    return lead, (1 - impedance) / impedance * float(model.dof_invweight0[dof])


def _extra(model: Any, name: str, index: int) -> float:
    """An entry that older versions of MuJoCo do not have; zero there."""
    return float(np.ravel(getattr(model, name)[index])[0]) if hasattr(model, name) else 0.0


def _actuators(model: Any, joint: int) -> list[int]:
    """The actuators that act on one joint directly."""
    import mujoco

    direct = {int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT)}
    return [
        a
        for a in range(len(model.actuator_trntype))
        if int(model.actuator_trntype[a]) in direct and model.actuator_trnid[a][0] == joint
    ]


def _efforts(model: Any) -> Array:
    """Effort limit (njnt,) [N m|N] of each joint: what its actuators can give through their gear; 0 without a limit."""
    limits = np.zeros(model.njnt)
    for joint in range(model.njnt):
        given = []
        for a in _actuators(model, joint):
            force = np.abs(model.actuator_forcerange[a]).max() if model.actuator_forcelimited[a] else 0.0
            given.append(float(force) * abs(float(model.actuator_gear[a][0])))
        if given and all(given):
            limits[joint] = sum(given)
        if model.jnt_actfrclimited[joint]:
            own = float(np.abs(model.jnt_actfrcrange[joint]).max())
            limits[joint] = min(own, limits[joint]) if limits[joint] else own
    return limits


def _enabled(model: Any, part: str) -> float:
    """1 where a part of the simulation is computed, 0 where the model's options switch it off."""
    import mujoco

    bit = getattr(mujoco.mjtDisableBit, f"mjDSBL_{part}", None)
    return 0.0 if bit is not None and int(model.opt.disableflags) & int(bit) else 1.0


def _left_out(model: Any, names: MjcfNames) -> list[str]:
    """Parts of the simulation with a torque that the model of an arm does not contain, in words."""
    bodies = [names.bodies[i] for i in np.flatnonzero(model.body_gravcomp)]
    curved = [
        names.joints[j]
        for j in range(model.njnt)
        if int(model.jnt_type[j]) >= 2
        and (_any(model, "dof_dampingpoly", model.jnt_dofadr[j]) or _any(model, "jnt_stiffnesspoly", j))
    ]
    tendons = [
        f"tendon {i + 1}"
        for i in range(model.ntendon)
        if any(_any(model, f"tendon_{key}", i) for key in ("stiffness", "damping", "frictionloss", "armature"))
    ]
    linear = {i for i, _, _ in coupled_joints(model)}
    held = [f"equality {i + 1}" for i in range(model.neq) if model.eq_active0[i] and i not in linear]
    texts = [
        ("the gravity compensation of", bodies),
        ("the nonlinear damping or stiffness of", curved),
        ("stiffness, damping, friction or armature of", tendons),
        ("the constraint", held),
    ]
    found = [f"{what} {_listed(where)}" for what, where in texts if where]
    if model.opt.density or model.opt.viscosity:
        found.append("the drag of the medium")
    return found


def _any(model: Any, name: str, index: int) -> bool:
    return hasattr(model, name) and bool(np.any(getattr(model, name)[index]))


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:LISTED]) + (f" and {len(names) - LISTED} more" if len(names) > LISTED else "")
