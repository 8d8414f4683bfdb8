"""The MuJoCo model of a machine: its bodies, their joints, and the joints that no drive moves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco as mj
import numpy as np
from numpy.typing import NDArray

from tests.plant_mujoco.machine import Machine

Array = NDArray[np.float64]
Index = NDArray[np.intp]
GEAR_DAMPING = 8e-4  # s: damping of an elastic gear over its stiffness
BASE_DAMPING = 2e-3  # s: the same of a flexible base
BASE_MASS, BASE_RADIUS = 12.0, 0.12  # kg, m
PLAY_DAMPING = 0.02  # N m s/rad: oil in the play of a gear
TOOTH_TIME = 2e-3  # s: how fast a gear's teeth stop
PENDULUM_DAMPING = 0.018  # of its critical damping
PENDULUM_RADIUS = 0.03  # m
RIGID = (0.9999, 0.9999, 1.0, 0.5, 2.0)  # MuJoCo's stiffest constraint impedance
STIFFER = 1e-2  # a stuck joint's constraint yields so much less than RIGID alone
OFF = ("CONTACT", "ISLAND", "SPRING", "DAMPER", "ACTUATION", "SENSOR", "AUTORESET", "REFSAFE")


@dataclass(frozen=True, eq=False)
class Bodies:
    """A compiled machine of n driven joints and nv degrees of freedom.

    ``dof`` and ``pos`` (n,) are the motors' places in velocity and position; ``stiffness``, ``damping`` (nv,) those of the
    passive joints, whose position is ``at`` (nv,) and of which ``free`` (nv,) have play; ``link`` (n, nv) sums motor and
    gear to the link's motion.
    """

    model: Any
    data: Any
    dof: Index
    pos: Index
    at: Index
    stiffness: Array
    damping: Array
    free: NDArray[np.bool_]
    link: Array
    tool: int
    place: Array


def compiled(made: Machine, links: Array) -> Bodies:
    """The MuJoCo model of a machine whose links have the parameters (n, 10)."""
    spec: Any = mj.MjSpec()
    spec.compiler.degree = False
    spec.option.gravity = made.gravity
    dry = made.friction.kind == "dry"
    body = _base(spec) if made.base else spec.worldbody
    for j, joint in enumerate(made.tree.joints):
        body = _placed(body, f"link{j}", joint.place)
        kind = mj.mjtJoint.mjJNT_HINGE if joint.kind == "hinge" else mj.mjtJoint.mjJNT_SLIDE
        body.add_joint(name=f"motor{j}", type=kind, axis=joint.axis, frictionloss=float(dry), armature=1.0)
        if made.compliance[j]:
            body.add_joint(name=f"twist{j}", type=kind, axis=joint.axis)
        if made.play[j]:
            half = float(made.play[j]) / 2
            body.add_joint(name=f"play{j}", type=kind, axis=joint.axis, limited=True, range=(-half, half))
    if made.pendulum:
        _placed(body, "pendulum", made.tree.tool).add_joint(name="swing", type=mj.mjtJoint.mjJNT_BALL)
    for i, pair in enumerate(made.couplings):
        tendon = spec.add_tendon(name=f"pair{i}", frictionloss=max(pair.dry, 1e-12))
        tendon.wrap_joint(f"motor{pair.first}", 1.0)
        tendon.wrap_joint(f"motor{pair.second}", 1.0)
    model = spec.compile()
    _set_masses(model, made, links)
    return _finished(model, made)


def _base(spec: Any) -> Any:
    """A plate under the arm that rocks about the x and y axes of the base."""
    body = _placed(spec.worldbody, "base", np.eye(4))
    for name, axis in (("rock_x", (1, 0, 0)), ("rock_y", (0, 1, 0))):
        body.add_joint(name=name, type=mj.mjtJoint.mjJNT_HINGE, axis=axis)
    return body


def _placed(parent: Any, name: str, place: Array) -> Any:
    turn = np.zeros(4)
    mj.mju_mat2Quat(turn, place[:3, :3].flatten())
    body = parent.add_body(name=name, pos=place[:3, 3], quat=turn)
    # any valid inertia without symmetry, of which MuJoCo would take advantage: the true one is written when compiled
    body.mass, body.inertia, body.explicitinertial = 1.0, (1.0, 1.1, 1.2), True
    body.ipos, body.iquat = (0.1, 0.2, 0.3), (0.9, 0.1, 0.2, 0.3)
    return body


def _set_masses(model: Any, made: Machine, links: Array) -> None:
    for j, row in enumerate(links):
        _set_mass(model, f"link{j}", row)
    if made.base:
        second = 0.4 * BASE_MASS * BASE_RADIUS**2
        _set_mass(model, "base", np.array([BASE_MASS, 0, 0, 0, second, 0, second, 0, 0, second]))
    if made.pendulum:
        mass, length = made.pendulum
        own = 0.4 * mass * PENDULUM_RADIUS**2
        second = own + mass * length**2
        _set_mass(model, "pendulum", np.array([mass, 0, 0, -mass * length, second, 0, second, 0, 0, own]))


def _set_mass(model: Any, name: str, row: Array) -> None:
    """Mass, centre and inertia of parameters (10,) about the body's frame, exact for any inertia tensor."""
    body, mass = model.body(name).id, row[0]
    centre = row[1:4] / mass if mass else np.zeros(3)
    xx, xy, yy, xz, yz, zz = row[4:]
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    tensor -= mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    moments, axes = np.linalg.eigh(tensor)
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    turn = np.zeros(4)
    mj.mju_mat2Quat(turn, axes.flatten())
    model.body_mass[body], model.body_ipos[body] = mass, centre
    model.body_inertia[body], model.body_iquat[body] = moments, turn


def _finished(model: Any, made: Machine) -> Bodies:
    for flag in OFF:
        model.opt.disableflags |= getattr(mj.mjtDisableBit, f"mjDSBL_{flag}")
    model.opt.tolerance, model.opt.ls_tolerance = 1e-14, 1e-6
    data: Any = mj.MjData(model)
    n, nv = made.n, model.nv
    motors = [model.joint(f"motor{j}") for j in range(n)]
    dof = np.array([m.dofadr[0] for m in motors], dtype=np.intp)
    pos = np.array([m.qposadr[0] for m in motors], dtype=np.intp)
    # a constraint yields in proportion to the joint's inertia, which includes its rotor
    model.dof_armature[dof] = made.rotor
    mj.mj_setConst(model, data)
    model.dof_armature[:] = 0.0
    model.dof_invweight0[dof] *= STIFFER
    model.dof_solimp[:], model.jnt_solimp[:] = RIGID, RIGID
    model.jnt_solref[:] = (TOOTH_TIME, 1.0)
    if made.couplings:
        model.tendon_invweight0[:] *= STIFFER
        model.tendon_solimp_fri[:] = RIGID
    at, stiffness, damping, link = np.zeros(nv, dtype=np.intp), np.zeros(nv), np.zeros(nv), np.zeros((n, nv))
    free = np.zeros(nv, dtype=bool)
    at[dof], link[np.arange(n), dof] = pos, 1.0
    for i in range(model.njnt):
        joint = model.joint(i)
        name, where = str(joint.name), joint.dofadr[0]
        if name == "swing":
            assert made.pendulum is not None
            mass, length = made.pendulum
            rate = np.sqrt(np.linalg.norm(made.gravity) / length)
            damping[where : where + 3] = 2 * PENDULUM_DAMPING * mass * length**2 * rate
            continue
        at[where] = joint.qposadr[0]
        if name.startswith("rock"):
            stiffness[where] = 1 / made.base
            damping[where] = BASE_DAMPING / made.base
        elif name.startswith("twist"):
            j = int(name[5:])
            stiffness[where] = 1 / made.compliance[j]
            damping[where], link[j, where] = GEAR_DAMPING / made.compliance[j], 1.0
        elif name.startswith("play"):
            damping[where], link[int(name[4:]), where], free[where] = PLAY_DAMPING, 1.0, True
    tool = model.body(f"link{n - 1}").id
    return Bodies(model, data, dof, pos, at, stiffness, damping, free, link, tool, made.tree.tool[:3, 3])
