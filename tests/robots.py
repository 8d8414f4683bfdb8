"""Robots for tests: a tree with a prismatic joint, and any Pinocchio model written as URDF."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

TREE = """<robot name="tree">
 <link name="base"/>
 <link name="cart"><inertial><origin xyz="0.1 -0.2 0.05" rpy="0.3 0.1 -0.2"/><mass value="3.0"/>
  <inertia ixx="0.05" ixy="0.001" ixz="0.002" iyy="0.06" iyz="-0.003" izz="0.04"/></inertial></link>
 <joint name="slide" type="prismatic"><parent link="base"/><child link="cart"/><origin xyz="0 0.1 0.2" rpy="0.2 0.3 0.4"/>
  <axis xyz="1 2 0.5"/><limit lower="-1" upper="1" velocity="2" effort="100"/></joint>
 <link name="left"><inertial><origin xyz="0 0.3 0.1" rpy="0 0 0"/><mass value="1.2"/>
  <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.01" iyz="0.002" izz="0.02"/></inertial></link>
 <joint name="left_turn" type="continuous"><parent link="cart"/><child link="left"/><origin xyz="0.2 0 0" rpy="0 1 0"/>
  <axis xyz="0 1 1"/></joint>
 <link name="right"><inertial><origin xyz="0.1 0 0.3" rpy="0.1 0 0"/><mass value="0.8"/>
  <inertia ixx="0.01" ixy="0" ixz="0.001" iyy="0.015" iyz="0" izz="0.012"/></inertial></link>
 <joint name="right_turn" type="revolute"><parent link="cart"/><child link="right"/><origin xyz="-0.2 0 0.1" rpy="0 0 1"/>
  <axis xyz="1 0 0"/><limit lower="-3" upper="3" velocity="3" effort="50"/></joint>
 <link name="tip"><inertial><origin xyz="0 0 0.1" rpy="0 0 0"/><mass value="0.4"/>
  <inertia ixx="0.002" ixy="0" ixz="0" iyy="0.002" iyz="0" izz="0.001"/></inertial></link>
 <joint name="tip_turn" type="revolute"><parent link="right"/><child link="tip"/><origin xyz="0 0 0.4" rpy="0.5 0 0"/>
  <axis xyz="-1 0.3 0.2"/><limit lower="-3" upper="3" velocity="3" effort="50"/></joint>
</robot>"""


def urdf_of(model: Any) -> str:
    """URDF text of a Pinocchio model whose joints are all revolute with an axis of their own."""
    lines = ['<robot name="model">', '<link name="body_0"/>']
    data = model.createData()
    for i in range(1, model.njoints):
        body, place = model.inertias[i], model.jointPlacements[i]
        axis = pin.computeJointJacobian(model, data, pin.neutral(model), i)[3:, model.idx_vs[i]]
        centre, mass = body.lever, float(body.mass)
        keys, places = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
        tensor = " ".join(f'{key}="{float(body.inertia[at])!r}"' for key, at in zip(keys, places, strict=True))
        lines.append(
            f'<link name="body_{i}"><inertial><origin xyz="{_join(centre)}" rpy="0 0 0"/><mass value="{mass!r}"/>'
            f"<inertia {tensor}/></inertial></link>"
            f'<joint name="joint_{i}" type="revolute"><parent link="body_{model.parents[i]}"/><child link="body_{i}"/>'
            f'<origin xyz="{_join(place.translation)}" rpy="{_join(pin.rpy.matrixToRpy(place.rotation))}"/>'
            f'<axis xyz="{_join(axis)}"/><limit lower="-3" upper="3" velocity="3" effort="100"/></joint>'
        )
    return "\n".join([*lines, "</robot>"])


def _join(values: Any) -> str:
    return " ".join(repr(float(x)) for x in np.asarray(values))
