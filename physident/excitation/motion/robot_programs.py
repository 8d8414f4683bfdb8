"""A motion as the programs that robots run: URScript, and a ROS 2 JointTrajectory in YAML."""

from __future__ import annotations

import re
from collections.abc import Sequence

from physident.excitation.motion.motion import Motion

APPROACH = 0.3  # rad/s, rad/s^2: of the move to a motion's start, slow enough to watch
MAX_UR_RATE = 500.0  # Hz, of servoj on an e-Series controller
LOOKAHEAD, GAIN = 0.1, 300  # s and proportional gain of servoj: the manufacturer's middle values
UR_JOINTS = 6


def urscript_of(name: str, motion: Motion, rate: float) -> str:
    """A URScript program that moves slowly to the start of a motion and then streams it with servoj; a comment for an arm
    of other than six joints, which URScript does not have.

    ``rate`` [Hz] is that of the set points, at most 500. Raises InputError for a rate that cannot be used.
    """
    if motion.n != UR_JOINTS:
        return f"# URScript is for arms of {UR_JOINTS} joints; this motion has {motion.n} (physident plan)\n"
    step = 1 / min(rate, MAX_UR_RATE)
    _, q, _, _ = motion.sample(1 / step)
    function = "motion_" + re.sub(r"\W", "_", name)
    lines = [
        f"def {function}():",
        f"  # {name}: {motion.duration:.2f} s, start logging before it begins (physident plan)",
    ]
    lines += [f"  movej({_row(q[0])}, a={APPROACH}, v={APPROACH})", "  sleep(1.0)"]
    lines += [f"  servoj({_row(row)}, t={step:.6g}, lookahead_time={LOOKAHEAD}, gain={GAIN})" for row in q]
    return "\n".join([*lines, "  stopj(2.0)", "  sleep(1.0)", "end", f"{function}()", ""])


def joint_trajectory_of(motion: Motion, joint_names: Sequence[str], rate: float) -> str:
    """A trajectory_msgs/msg/JointTrajectory as YAML: positions, velocities, accelerations and times at a rate [Hz].

    Raises InputError for a rate that cannot be used.
    """
    time, q, v, a = motion.sample(rate)
    lines = [
        "# trajectory_msgs/msg/JointTrajectory (physident plan)",
        "joint_names:",
        *(f"  - {_quoted(name)}" for name in joint_names),
    ]
    lines.append("points:")
    for t, *state in zip(time, q, v, a, strict=True):
        nanoseconds = round(float(t) * 1e9)
        rows = zip(("positions", "velocities", "accelerations"), state, strict=True)
        first, *rest = [f"{key}: {_row(row)}" for key, row in rows]
        lines += [f"  - {first}", *(f"    {text}" for text in rest)]
        lines.append(f"    time_from_start: {{sec: {nanoseconds // 10**9}, nanosec: {nanoseconds % 10**9}}}")
    return "\n".join([*lines, ""])


def _row(values: Sequence[float]) -> str:
    return "[" + ", ".join(f"{0.0 if abs(v) < 5e-9 else v:.8f}" for v in values) + "]"


def _quoted(name: str) -> str:
    """A name as YAML reads it back, whatever it contains."""
    return '"' + name.replace("\\", "\\\\").replace('"', '\\"') + '"'
