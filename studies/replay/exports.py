"""The torque of each exported file of the UR10e's models, with the measurement's effects added, beside the model's own."""

from __future__ import annotations

from dataclasses import replace

from ur10e import models

import physident as pid
from physident.export.mjcf.callback import with_callback
from physident.export.mjcf.mjcf import mjcf_of
from physident.export.urdf import urdf_of


def study() -> tuple[dict, list[str]]:
    before, after, fitted, _ = models()
    results: dict = {}
    rows = ["100 |measured - predicted| / |measured| [%]       joint 1      2      3      4      5      6"]
    for name, estimate in (("before", before), ("after", after)):
        mjcf = mjcf_of(estimate.model).held
        parts = {"the model": estimate.model, "URDF": urdf_of(estimate.model).held.model, "MJCF": mjcf.model}
        if mjcf.left_out:
            parts["MJCF with its callback"] = with_callback(mjcf).model
        for form, model in parts.items():
            score = pid.validate(replace(estimate, model=model), fitted, include_fitted=True)
            results[f"{name}: {form}"] = score.relative.tolist()
            rows.append(f"{name + ': ' + form:<50}" + "".join(f"{x:7.2f}" for x in score.relative))
    return results, rows
