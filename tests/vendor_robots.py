"""Descriptions as vendors ship them, for tests: a mobile base with two arms and a gripper, and a MuJoCo arm."""

from __future__ import annotations

import importlib.metadata
from pathlib import Path

ROD = (
    '<inertial><origin xyz="0.02 -0.01 0.12" rpy="0.1 0.2 0.3"/><mass value="{mass}"/>'
    '<inertia ixx="0.03" ixy="0.001" ixz="-0.002" iyy="0.028" iyz="0.0015" izz="0.01"/></inertial>'
)


def _link(name: str, mass: float) -> str:
    return f'<link name="{name}">{ROD.format(mass=mass)}</link>'


def _joint(name: str, kind: str, parent: str, child: str, rest: str = "", axis: str = "0 1 0") -> str:
    limit = '<limit lower="-2" upper="2" velocity="3" effort="80"/>' if kind != "floating" else ""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0.05 0.1 0.3" rpy="0.2 -0.1 0.4"/><axis xyz="{axis}"/>{limit}{rest}</joint>'
    )


def _arm(side: str) -> str:
    finger = f'<mimic joint="{side}_finger_1" multiplier="-2" offset="0.1"/>'
    return "".join(
        [
            _link(f"{side}_upper", 3.0), _joint(f"{side}_1", "revolute", "torso", f"{side}_upper", axis="0 1 1"),
            _link(f"{side}_fore", 2.0), _joint(f"{side}_2", "continuous", f"{side}_upper", f"{side}_fore", axis="1 0 0"),
            _link(f"{side}_hand", 1.0), _joint(f"{side}_3", "revolute", f"{side}_fore", f"{side}_hand", axis="0 0 1"),
            f'<link name="{side}_tcp"/>', _joint(f"{side}_flange", "fixed", f"{side}_hand", f"{side}_tcp"),
            _link(f"{side}_tip_1", 0.2), _joint(f"{side}_finger_1", "prismatic", f"{side}_hand", f"{side}_tip_1"),
            _link(f"{side}_tip_2", 0.2), _joint(f"{side}_finger_2", "prismatic", f"{side}_hand", f"{side}_tip_2", finger),
        ]
    )  # fmt: skip


# floating base, wheels, lift, two arms whose names sort left first, and a gripper of two coupled fingers on each
MOBILE = (
    '<robot name="mobile"><!-- as shipped --><link name="world"/>'
    + _link("platform", 40.0) + _joint("drive", "floating", "world", "platform")
    + _link("wheel", 2.0) + _joint("wheel_1", "continuous", "platform", "wheel")
    + _link("torso", 10.0) + _joint("lift", "prismatic", "platform", "torso", axis="0 0 1")
    + _arm("left") + _arm("right") + "</robot>"
)  # fmt: skip


def packaged(file: str) -> Path | None:
    """A file of the package example-robot-data, None where it is not installed."""
    try:
        entries = importlib.metadata.files("example-robot-data") or []
    except importlib.metadata.PackageNotFoundError:
        return None
    return next((Path(str(entry.locate())) for entry in entries if str(entry).endswith(f"/{file}")), None)


def mjcf(
    *, damping: float = 8.0, friction: float = 4.0, mass: float = 4.0, armature: float = 0.3, option: str = ""
) -> str:
    """A MuJoCo arm of four joints; the arguments are those of its elbow and of the link behind it."""
    return f"""<mujoco model="arm"><option timestep="0.001" integrator="implicitfast"/>{option}<worldbody>
 <body name="base" pos="0 0 0.1"><body name="shoulder" pos="0 0 0.1"><joint name="pan" axis="0 0 1" damping="8" armature="0.5" frictionloss="4"/>
  <inertial pos="0 0 .05" mass="5" diaginertia=".03 .03 .02"/>
  <body name="upper" pos="0 0.1 0.1"><joint name="lift" axis="0 1 0" damping="8" armature="0.4" frictionloss="5"/>
   <inertial pos="0.02 0.01 .25" mass="6" diaginertia=".12 .12 .02"/>
   <body name="fore" pos="0 -0.1 0.45"><joint name="elbow" axis="0 1 0" damping="{damping}" armature="{armature}" frictionloss="{friction}"/>
    <inertial pos="0.01 0.02 .2" mass="{mass}" diaginertia=".06 .06 .01"/>
    <body name="hand" pos="0 0 0.4"><joint name="wrist" axis="1 0 0" damping="2" armature="0.1" frictionloss="1.5"/>
     <inertial pos="0 .03 .08" mass="1.5" diaginertia=".006 .006 .002"/></body></body></body></body></body>
 </worldbody><actuator><motor joint="pan" gear="100"/><motor joint="lift" gear="100"/><motor joint="elbow" gear="80"/>
 <motor joint="wrist" gear="50"/></actuator></mujoco>"""


# several joints on one body, anchors, references, springs, a slide, coupled fingers, an actuator with armature, a free cube
MJCF_OF_ALL_KINDS = """<mujoco model="all"><compiler angle="radian"/><option gravity="0.3 -0.5 -9.7"/><worldbody>
 <geom type="plane" size="1 1 .1"/><body name="base" pos="0.1 0.2 0.3" quat="0.9 0.1 0.2 0.3"><geom type="box" size=".1 .1 .1"/>
 <body name="a" pos="0 0.1 0.2" euler="0.3 0.2 -0.4">
  <joint name="j1" axis="1 2 0.5" pos="0.1 -0.05 0.2" ref="0.3" range="-2 2" damping="1.5" armature="0.2" frictionloss="0.7"
   stiffness="3" springref="0.4"/>
  <joint name="s1" type="slide" axis="0 1 1" pos="0.3 0.1 0" ref="-0.1" range="-1 1" damping="2" armature="0.5" frictionloss="2"/>
  <joint name="j2" axis="0 0 1" pos="-0.1 0.1 0.05" armature="0.1" frictionloss="1" solreffriction="-100 -60"/>
  <geom type="capsule" size="0.05 0.2" pos="0.1 0 0.2" euler="0.1 0.5 0"/>
  <body name="b" pos="0.2 0.1 0.4" quat="0.5 0.5 -0.5 0.5"><joint name="j3" axis="0 1 0" pos="0.02 0 0.1" ref="-0.5" damping="0.3"/>
   <inertial pos="0.1 0.02 0.03" mass="1.3" fullinertia="0.02 0.03 0.025 0.001 -0.002 0.003"/><geom type="sphere" size=".05"/>
   <body name="tool" pos="0 0 .3"><geom type="cylinder" size=".03 .1"/>
    <body name="f1" pos="0 .05 0"><joint name="f1" type="slide" axis="0 1 0" range="0 .04"/><geom type="box" size=".01 .01 .03"/></body>
    <body name="f2" pos="0 -.05 0"><joint name="f2" type="slide" axis="0 -1 0" range="0 .04"/><geom type="box" size=".01 .01 .03"/></body>
 </body></body></body></body>
 <body name="cube" pos="1 1 1"><freejoint/><geom type="box" size=".1 .1 .1"/></body></worldbody>
 <equality><joint joint1="f1" joint2="f2"/></equality>
 <actuator><motor joint="j1" gear="50" forcerange="-2 2" forcelimited="true"/><motor joint="j3" gear="10" armature="0.001"/>
 </actuator></mujoco>"""
