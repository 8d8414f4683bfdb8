"""What every program of the comparison does alike: its arguments, the processor time of its stages, and its answer."""

from __future__ import annotations

import json
import resource
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

Array = np.ndarray


def columns(table: pd.DataFrame, name: str) -> Array:
    """Columns ``name_1`` to ``name_n`` of a recording (N, n); none of them where it has none (N, 0)."""
    return table[[column for column in table.columns if column.startswith(f"{name}_")]].to_numpy()


@dataclass
class Stages:
    """Processor time [s] of the stages of this process; a stage ends when it is named, the first with what was imported."""

    seconds: dict[str, float] = field(default_factory=dict)
    last: float = 0.0

    def end(self, name: str) -> None:
        now = time.process_time()
        self.seconds[name], self.last = now - self.last, now


@dataclass(frozen=True)
class Call:
    """``program.py TASK METHOD CUTOFF OUT``: the folder of a task, the method, the low-pass [Hz], and the predictions' file."""

    task: Path
    method: str
    cutoff: float
    out: Path

    @classmethod
    def read(cls) -> Call:
        task, method, cutoff, out = sys.argv[1:]
        return cls(Path(task), method, float(cutoff), Path(out))

    def answer(self, stages: Stages, time: Array, torque: Array, **model: Any) -> None:
        """Write the predicted torque (N, n) [N m] at times (N,) [s]; print times, peak memory [MB] and the model's parameters."""
        joints = range(1, torque.shape[1] + 1)
        header = ",".join(["time", *(f"tau_{joint}" for joint in joints)])
        np.savetxt(self.out, np.column_stack([time, torque]), delimiter=",", header=header, comments="")
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        values = {name: np.asarray(value).tolist() for name, value in model.items()}
        print(json.dumps({"seconds": stages.seconds, "memory": memory, **values}))
