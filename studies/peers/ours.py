"""The same task by physident: `ours.py TASK ols|wls|physical|diagnosed CUTOFF OUT`."""

from __future__ import annotations

import numpy as np
import pandas as pd
from program import Call, Stages, columns

import physident as pid
from physident.effects.catalogue import DEFAULT_EFFECTS


def main() -> None:
    call, stages = Call.read(), Stages()
    filter = pid.Filter(cutoff=call.cutoff)
    effects = pid.make_effects(DEFAULT_EFFECTS)
    stages.end("imports")
    robot = pid.load_robot(call.task / "robot.urdf")
    train = pid.load_recordings(str(call.task / "train_*.csv"))
    stages.end("read")
    pid.build_regressor(robot, effects, [pid.prepare(run, filter) for run in train], filter)
    stages.end("regressor")
    pid.build_regressor(robot, effects, [pid.prepare(run, filter) for run in train], filter)
    stages.end("again")  # `identify` makes the regressor itself: this much of its time is no fit
    method = "wls" if call.method == "diagnosed" else call.method
    estimate = pid.identify(robot, train, method=method, filter=filter)
    stages.end("fit")
    stages.seconds["fit"] -= stages.seconds.pop("again")
    if call.method == "diagnosed":
        estimate = pid.diagnose_motion(estimate, train).estimate or estimate  # none where nothing was found
        stages.end("diagnose")
    table = pd.read_csv(call.task / "test.csv")
    q, dq = columns(table, "q"), columns(table, "dq")
    test = pid.Recording.from_arrays(table["time"].to_numpy(), q, np.zeros_like(q), dq, source="test.csv")
    signals = pid.prepare(test, filter)
    torque = estimate.model.torque(signals)
    stages.end("predict")
    model = estimate.model
    values = {
        name: model.parameters(effect)
        for name, effect in (("viscous", "viscous_friction"), ("dry", "coulomb_friction"))
    }
    call.answer(
        stages,
        signals.time,
        torque,
        links=model.parameters("rigid_body"),
        effects=[e.name for e in model.effects],
        **values,
    )


if __name__ == "__main__":
    main()
