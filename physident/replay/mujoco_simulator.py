"""Forward dynamics of many arms in MuJoCo: the exported MJCF, and in every step the effects that MJCF does not hold."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.errors import InputError
from physident.export.mjcf.mjcf import MjcfExport, mjcf_of
from physident.export.mujoco import mujoco_module
from physident.replay.arm import Arm
from physident.replay.own_simulator import STEP, Drive, Trace
from physident.simulation.plant import Instants

Array = NDArray[np.float64]
CHUNK = 256  # arms whose whole torque is laid out at once


@dataclass(frozen=True, eq=False)
class MujocoArm:
    """A model's arm in MuJoCo, without contacts and joint limits, which a recorded motion does not reach.

    Raises InputError where MuJoCo is not installed, and for a model whose links cannot exist.
    """

    model: Model

    @cached_property
    def exported(self) -> MjcfExport:
        """The model as MJCF, and what that does not hold."""
        try:
            return mjcf_of(self.model)
        except InputError as error:
            raise InputError(f"{error}; or replay with --simulator physident") from None

    @cached_property
    def compiled(self) -> Any:
        """The compiled MuJoCo model."""
        mujoco = mujoco_module()
        compiled = mujoco.MjModel.from_xml_string(self.exported.text)
        off = mujoco.mjtDisableBit
        # without a reset, an arm that runs away stays lost instead of returning to its first state
        compiled.opt.disableflags |= off.mjDSBL_CONTACT | off.mjDSBL_LIMIT | off.mjDSBL_AUTORESET
        return compiled

    @cached_property
    def left_out(self) -> Arm | None:
        """The effects of the plant that MJCF does not hold, as an arm without inertia; or None."""
        parts = [(effect, theta) for effect, theta in self.exported.held.left_out if effect.acts_on == "plant"]
        if not parts:
            return None
        theta = np.concatenate([values for _, values in parts])
        return Arm(Model(self.model.robot, tuple(effect for effect, _ in parts), theta))

    def simulate(
        self, clock: Array, start: Array, state: Array, q: Array, v: Array, drive: Drive, closed: bool
    ) -> Trace:
        """As ``simulate_batch``; ``closed`` says whether the drives' torque depends on the simulated state.

        ``state`` (S, N) are the internal states of the effects that MJCF leaves out.
        """
        substeps = max(1, int(np.ceil((clock[1] - clock[0]) / STEP - 1e-9)))
        h = float(clock[1] - clock[0]) / substeps
        self.compiled.opt.timestep = h
        rollout = _rollout_module()
        threads = os.cpu_count() or 1
        datas = [mujoco_module().MjData(self.compiled) for _ in range(threads)]
        with rollout.Rollout(nthread=threads) as pool:
            if closed or self.left_out is not None:
                return self._stepwise(pool, datas, clock, substeps, h, start, state, q, v, drive)
            parts = [
                self._at_once(pool, datas, clock, substeps, h, q, v, drive, slice(first, first + CHUNK))
                for first in range(0, len(q), CHUNK)
            ]
        return Trace(*(np.concatenate([getattr(part, name) for part in parts]) for name in ("q", "v", "torque")))

    def _at_once(self, pool: Any, datas: Any, clock: Array, substeps: int, h: float, q: Array, v: Array, drive: Drive,
                 part: slice) -> Trace:  # fmt: skip
        """A chunk of arms whose torque is known in advance, rolled out in one call."""
        n = q.shape[1]
        steps = (len(clock) - 1) * substeps
        control = np.stack([drive(k * h, q, v)[part] for k in range(steps)], axis=1)
        states = self._states(q[part], v[part])
        after, _ = pool.rollout(self.compiled, datas, states, control, control_spec=self._applied)
        kept = np.concatenate([states[:, None], after[:, substeps - 1 :: substeps]], axis=1)
        torque = np.stack([drive(float(time), q, v)[part] for time in clock], axis=1)
        return Trace(kept[..., 1 : 1 + n], kept[..., 1 + n : 1 + 2 * n], torque)

    def _stepwise(self, pool: Any, datas: Any, clock: Array, substeps: int, h: float, start: Array, state: Array,
                  q: Array, v: Array, drive: Drive) -> Trace:  # fmt: skip
        """All arms step by step, with torques that depend on their states."""
        N, n = q.shape
        whole, a = Arm(self.model), np.zeros_like(q)
        kept = [np.empty((N, len(clock), n)) for _ in range(3)]
        states = self._states(q, v)
        for k, time in enumerate(clock):
            for part, values in zip(kept, (q, v, drive(float(time), q, v)), strict=True):
                part[:, k] = values
            for sub in range(substeps if k + 1 < len(clock) else 0):
                now = float(time) + sub * h
                torque = drive(now, q, v)
                if self.left_out is not None:
                    M, bias = whole.dynamics(q, v)
                    at = Instants(start + now, q, v, a, np.einsum("kij,kj->ki", M, a) + bias, state)
                    torque = torque - self.left_out.plant.torque(at)
                    state = self.left_out.advanced(at, h)
                after, _ = pool.rollout(self.compiled, datas, states, torque[:, None], control_spec=self._applied)
                states = after[:, 0]
                q, before, v = states[:, 1 : 1 + n], v, states[:, 1 + n : 1 + 2 * n]
                a = (v - before) / h
        return Trace(*kept)

    @cached_property
    def _applied(self) -> int:
        return int(mujoco_module().mjtState.mjSTATE_QFRC_APPLIED)

    def _states(self, q: Array, v: Array) -> Array:
        """MuJoCo's states (N, 1 + 2 n): time, positions and velocities; the exported file has the model's order of joints."""
        names = [self.compiled.joint(k).name for k in range(self.compiled.njnt)]
        if tuple(names) != self.model.robot.joint_names:
            raise InputError(
                f"robot {self.model.robot.name}: MuJoCo orders its joints {', '.join(names)}; replay with --simulator physident"
            )
        return np.concatenate([np.zeros((len(q), 1)), q, v], axis=1)


def _rollout_module() -> Any:
    from mujoco import rollout

    return rollout
