"""A second robot arm for tests, in MuJoCo: it shares no code with the package that is tested or with the first plant.

run = MujocoPlant().simulate(arm, motion)
"""

from __future__ import annotations

from tests.plant_mujoco.plant import MujocoPlant

__all__ = ["MujocoPlant"]
