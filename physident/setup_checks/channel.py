"""What the effort channel is: of a geared motor, of a sensor behind the gear, or a model's; or one kind on some joints, another on others.

Friction of a geared joint is a tenth of its gravity and inertia torque or far more. A sensor behind the gear shows hardly any,
and neither does the torque of a rigid-body model, which has no noise either.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from physident.recordings.recording import Recording
from physident.setup_checks.finding import SetupFinding, joint_list
from physident.setup_checks.jackknife import Interval, jackknife
from physident.setup_checks.joint_fit import Moments, coefficients
from physident.setup_checks.rows import Rows

Array = NDArray[np.float64]
NO_FRICTION = 0.1  # of inertia and gravity: gears of arms lose more than a tenth
FRICTION = 0.15  # of inertia and gravity: no sensor behind the gear shows as much
REVERSES = 0.5  # standard deviation of the direction of motion over its RMS: less where 93 % of the motion is one way
EXACT = 1e-3  # of the effort's standard deviation: current and torque sensors have more noise
CHANGING = 0.05  # share of samples that differ from the ones before: fewer say nothing about noise
UNLIKE = 30.0  # noise of one joint over that of another, both relative: sensors of one arm are not so different


def check_channel(rows: Rows, moments: Moments, recordings: Sequence[Recording]) -> SetupFinding | None:
    """What kind of channel the efforts are, where they are not those of geared motors on all joints."""
    noise = relative_noise(recordings)
    exact = noise < EXACT
    noisy = noise > UNLIKE * max(float(noise[exact].max(initial=0.0)), EXACT / 10)
    if exact.any() and noisy.any() and (exact | noisy).all():
        return _mixture(
            exact,
            "have no noise, as a model's torque",
            f"noise up to {noise[exact].max():.1e} and from {noise[noisy].min():.1e} of the effort",
        )
    share, strong = friction_share(rows, moments)
    free, geared = strong & (share.high < NO_FRICTION), strong & (share.low > FRICTION)
    if free.any() and geared.any() and (free | geared)[strong].all():
        values = f"friction at most {100 * share.high[free].max():.0f} % and at least {100 * share.low[geared].min():.0f} % of inertia and gravity torque"
        return _mixture(free, "hold no friction", values)
    if not (free[strong].all() and strong.any()):
        return None
    joints = joint_list(np.flatnonzero(strong) + 1)
    evidence = (
        f"friction is at most {100 * share.high[strong].max():.1f} % of the inertia and gravity torque of {joints}"
    )
    if (noise[strong] < EXACT).any() and not (noise[strong] >= EXACT).any():
        return SetupFinding(
            kind="model_torque",
            joints=(),
            statement="the efforts are a model's torque, not a measurement: they hold neither noise nor friction; record measured torques or currents",
            evidence=f"{evidence}, noise {np.nanmax(noise[strong]):.1e} of the effort",
            void=True,
        )  # fmt: skip
    return SetupFinding(
        kind="link_side",
        joints=(),
        statement="the efforts are measured behind the gears, at the links: rotor inertia and friction of the gears are not in them",
        evidence=evidence,
        void=False,
        note=True,
    )


def friction_share(rows: Rows, moments: Moments) -> tuple[Interval, NDArray[np.bool_]]:
    """Friction of each joint (n,) over its inertia and gravity torque, and which joints (n,) move and have much of the latter."""
    columns = rows.columns

    def shares(block: int | None) -> Array:
        theta = coefficients(moments, block)
        parts = columns * theta[:, None, :]
        rigid, friction = parts[:, :, :3].sum(axis=2).std(axis=1), parts[:, :, 3:].sum(axis=2).std(axis=1)
        return friction / np.maximum(rigid, 1e-12 * max(float(rigid.max()), 1e-12))

    replicates = np.array([shares(block) for block in range(moments.blocks)])
    # what turns one way shows no friction that an offset could not be
    moves = rows.moving() & (columns[:, :, 4].std(axis=1) > REVERSES * np.sqrt((rows.sign**2).mean(axis=0)))
    return jackknife(shares(None), replicates), rows.strong() & moves


def relative_noise(recordings: Sequence[Recording]) -> Array:
    """Noise (n,) of each channel from sample to sample, over its standard deviation; the largest of the recordings.

    Samples that repeat the one before them are left out, and steps count as the noise that they round to: an effort that is clipped or in coarse
    steps is not therefore exact. NaN where hardly any are left.
    """
    worst = np.full(recordings[0].n, np.nan)
    for recording in recordings:
        size = recording.effort.std(axis=0)
        step = np.diff(recording.effort, axis=0)
        third = np.abs(np.diff(step, 2, axis=0))
        changing = (step[:-2] != 0) & (step[1:-1] != 0) & (step[2:] != 0)
        for j in range(recording.n):
            if changing[:, j].mean() > CHANGING and size[j] > 0:
                # of white noise a third difference has 20 times the variance; 0.6745 turns a median into a standard deviation
                noise = float(np.median(third[changing[:, j], j])) / (0.6745 * np.sqrt(20.0))
                rounded = float(np.abs(step[step[:, j] != 0, j]).min()) / np.sqrt(12.0)
                worst[j] = np.fmax(worst[j], max(noise, rounded) / size[j])
    return worst


def _mixture(chosen: NDArray[np.bool_], what: str, evidence: str) -> SetupFinding:
    joints = tuple(int(j) + 1 for j in np.flatnonzero(chosen))
    return SetupFinding(
        kind="mixture",
        joints=joints,
        statement=f"the efforts are of two kinds: those of {joint_list(joints)} {what}, the others do; record one kind of channel",
        evidence=evidence,
        void=True,
    )
