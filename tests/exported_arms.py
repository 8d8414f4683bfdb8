"""An arm whose links are fixed together, and models of it, for the tests of exports."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import physident as pid
from physident.robots.inertia import link_parameters

NASTY = 'a"); import os; os.system("x"); (" */ <b> &amp; \' ${x} `y`'
LUMPED = """<?xml version="1.0" encoding="utf-8"?>
<!-- before the root: größer -->
<robot name="lumped" xmlns:xacro="http://ros.org/wiki/xacro">
  <material name="grey"><color rgba="0.7 0.7 0.7 1.0"/></material>
  <link name="world"/>
  <link name="base"><inertial><mass value="4.0"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <joint name="mount" type="fixed"><parent link="world"/><child link="base"/></joint>
  <link name="arm"/>
  <joint name="shoulder" type="revolute"> <!-- turns -->
    <parent link="base"/><child link="arm"/><origin xyz="0 0 0.4" rpy="0.1 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" velocity="3" effort="100"/>
  </joint>
  <link name="cover"><!-- bolted on -->
    <inertial>
      <origin xyz="0.1 0 0.2" rpy="0.4 -0.3 0.2"/>
      <mass value="2.0"/>
      <inertia ixx="0.02" ixy="0.001" ixz="0" iyy="0.03" iyz="0.002" izz="0.025"/>
    </inertial>
    <visual><geometry><mesh filename="package://x/&lt;cover&gt;.dae"/></geometry></visual>
  </link>
  <joint name="bolts" type="fixed"><parent link="arm"/><child link="cover"/><origin xyz="0 0.1 0" rpy="0 0 0.5"/></joint>
  <link name="tool"><inertial><origin xyz="0 0 0.1"/><mass value="1.0"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.005"/></inertial></link>
  <joint name="elbow" type="revolute"><parent link="cover"/><child link="tool"/><origin xyz="0 0 0.3"/><axis xyz="1 0 0"/>
    <limit lower="-3" upper="3" velocity="3" effort="50"/><dynamics friction="7" damping="3" springref="1"/></joint>
  <link name="flange"/>
  <joint name="screw" type="fixed"><parent link="tool"/><child link="flange"/></joint>
  <transmission name="t"><joint name="elbow"><hardwareInterface>E</hardwareInterface></joint></transmission>
  <gazebo reference="arm"><selfCollide>true</selfCollide></gazebo>
</robot>
<!-- after the root -->
"""


def lumped() -> pid.Robot:
    return pid.Robot("lumped", LUMPED)


def physical_model(robot: pid.Robot, seed: int) -> pid.Model:
    """A model with random solid links and random friction, so that no nominal value can pass for an identified one."""
    rng = np.random.default_rng(seed)
    model = pid.Model.nominal(robot)
    links = []
    for _ in range(robot.n):
        root = rng.normal(size=(4, 4)) * np.array([0.2, 0.2, 0.2, 1.0])[:, None]
        links.append(link_parameters(root @ root.T + 1e-3 * np.eye(4)))
    rest = rng.uniform(0.1, 2.0, size=len(model.theta) - 10 * robot.n)
    return replace(model, theta=np.concatenate([*links, rest]))


def random_states(robot: pid.Robot, seed: int, count: int) -> pid.Signals:
    return pid.Signals.of_states(*np.random.default_rng(seed).uniform(-2, 2, size=(3, count, robot.n)))


def named_after_code() -> pid.Robot:
    """The lumped arm, whose own name and that of whose elbow are code in several languages."""
    escaped = NASTY.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
    return pid.Robot(NASTY, LUMPED.replace('"elbow"', f'"{escaped}"').replace('name="lumped"', f'name="{escaped}"'))
