"""The effects that MJCF cannot hold as a Python callback for MuJoCo: one file that needs numpy and mujoco only."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from physident.dynamics.model import Model
from physident.effects.classification import units_in_words
from physident.effects.effect import Effect
from physident.errors import InputError
from physident.export.held import Held, described
from physident.export.python import RIGID_BODY, constants_of, plain, uses


def callback_of(model: Model, held: Held) -> str | None:
    """Source text of a callback with the torque of the effects that MJCF leaves out; None where it leaves out none.

    Raises InputError where none of them is a function of the state at one instant and of the time.
    """
    if not held.left_out:
        return None
    robot, inertia = model.robot, model.added_inertia()
    sources = [(effect, theta, _source(effect, model, theta)) for effect, theta in held.left_out]
    known = [(effect, source) for effect, _, source in sources if source is not None]
    missing = [described(model.robot, effect, theta) for effect, theta, source in sources if source is None]
    if not known:
        raise InputError(
            f"a callback cannot express {', '.join(missing)}; expected effects that depend on one instant: leave --callback out"
        )
    needs_load = any(uses(source, "load") for _, source in known)
    load = "rigid_body(q, v, a)" if needs_load else "None"
    body = "\n    ".join(
        f"tau += {source}  # {effect.name} [{units_in_words(effect.columns(robot))}]" for effect, source in known
    )
    rigid = constants_of(robot, inertia.links, np.array(robot.gravity) + inertia.gravity) + RIGID_BODY
    left = "".join(f"\nNot in this file either: {plain(text)}." for text in missing)
    return f'''"""Joint torques of {plain(robot.name)} that its MJCF does not hold, as a callback for MuJoCo, identified with physident.

    model = mujoco.MjModel.from_xml_path("arm.xml")
    install(model)
{left}
"""

import mujoco
import numpy as np

NAMES = {tuple(robot.joint_names)!r}
{rigid if needs_load else ""}

def effects(q, v, a, t):
    """Torques (n,) [N m|N] that a motion needs beyond those of the MJCF: q [rad|m], v [rad/s|m/s], a, each (n,); t [s]."""
    load = {load}
    tau = np.zeros({robot.n})
    {body}
    return tau


def install(model):
    """Let MuJoCo apply the effects in every step of this model; ``mujoco.set_mjcb_passive(None)`` ends it."""
    joints = [model.joint(name) for name in NAMES]
    positions = np.array([joint.qposadr[0] for joint in joints])
    velocities = np.array([joint.dofadr[0] for joint in joints])
    size = model.nv

    def passive(model, data):
        if model.nv == size:
            a = data.qacc[velocities]  # of the step before
            tau = effects(data.qpos[positions], data.qvel[velocities], a, data.time)
            data.qfrc_passive[velocities] -= tau

    mujoco.set_mjcb_passive(passive)
'''


def with_callback(held: Held) -> Held:
    """The part of a model that an MJCF file holds together with its callback."""
    robot, parts = held.model.robot, held.model.effect_parameters()
    parts += [(effect, theta) for effect, theta in held.left_out if _source(effect, held.model, theta) is not None]
    theta = np.concatenate([values for _, values in parts])
    return replace(held, model=Model(robot, tuple(effect for effect, _ in parts), theta))


def _source(effect: Effect, model: Model, theta: np.ndarray) -> str | None:
    """The effect's torque as an expression of one instant; None where it has none or remembers."""
    if effect.advance_source(model.robot) is not None:
        return None
    return model.source_of(effect, theta)
