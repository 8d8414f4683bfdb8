"""Draws docs/pictures/reversal.png: the sign of a joint's velocity at two reversals, as it is, as a steep curve, and as expected."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np

mpl.use("Agg")
import matplotlib.pyplot as plt

from physident.graphics.style import AS_IT_WAS, MEASURED, RESIDUAL, SETTINGS
from physident.recordings.motion_smoothing import estimate_noise, smooth_motion
from physident.recordings.rests import find_rests
from physident.recordings.velocity_sign import velocity_sign

RATE, STEP, NOISE = 125.0, 5e-5, 5e-3  # Hz, rad, rad/s
TARGET = Path(__file__).resolve().parent / "pictures" / "reversal.png"


def main() -> None:
    time = np.arange(0, 4, 1 / RATE)
    v = 0.25 * np.sin(2 * np.pi * 0.5 * time + 0.4)
    stuck = (np.abs(v) < 0.03) & (time > 2)  # the second half sticks at its reversals
    v = np.where(stuck, 0.0, v - 0.03 * np.sign(v) * (time > 2))
    q = np.concatenate([[0.0], np.cumsum((v[1:] + v[:-1]) / 2)]) / RATE
    rng = np.random.default_rng(3)
    measured_q, measured_v = np.round(q / STEP) * STEP, v + NOISE * rng.standard_normal(len(v))
    noise = estimate_noise(measured_q, measured_v, RATE, STEP)
    motion = smooth_motion(measured_q, measured_v, RATE, noise)
    rests = find_rests(motion.q, motion.v, noise.position_range)
    sign, spread = velocity_sign(motion.v, motion.a / (2 * RATE), motion.v_std, rests)
    mpl.rcParams.update(SETTINGS)
    figure, axes = plt.subplots(1, 2, figsize=(9, 3), sharey=True, layout="constrained")
    for axis, (start, stop), title in zip(
        axes, ((0.6, 1.15), (2.5, 3.1)), ("a crossing of zero", "a rest"), strict=True
    ):
        rows = (time >= start) & (time <= stop)
        t = time[rows]
        axis.plot(t, np.where(stuck, np.nan, np.sign(v))[rows], color=MEASURED, lw=3, alpha=0.4)
        axis.plot(t, np.tanh(measured_v / 0.01)[rows], color=RESIDUAL, lw=1)
        axis.plot(t, sign[rows], color=AS_IT_WAS, lw=1.6)
        axis.fill_between(t, (sign - spread)[rows], (sign + spread)[rows], color=AS_IT_WAS, alpha=0.15, lw=0)
        axis.set(title=title, xlabel="time [s]", ylim=(-1.7, 1.7))
    axes[0].set_ylabel("sign of velocity")
    figure.savefig(TARGET, dpi=110)


if __name__ == "__main__":
    main()
