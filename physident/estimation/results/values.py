"""The parameters of an estimate as a table (pandas) and as a figure (matplotlib)."""

from __future__ import annotations

from typing import Any

import numpy as np

from physident.errors import InputError
from physident.estimation.estimated_model import EstimatedModel
from physident.estimation.uncertainty import t_quantile

ROW = 0.22  # inch: height of a parameter in the figure


def value_frame(estimate: EstimatedModel) -> Any:
    """A pandas frame with a row for each parameter: joint, effect, value, unit, standard error, 95 % interval.

    The standard error is NaN for a parameter that torques determine only in a sum. Raises InputError without pandas.
    """
    try:
        import pandas as pd
    except ImportError:
        raise InputError("to_frame needs pandas, which is not installed; expected pip install pandas") from None
    half = t_quantile(estimate.blocks) * estimate.standard_errors
    columns = estimate.model.columns
    return pd.DataFrame(
        {
            "joint": [column.joint for column in columns],
            "effect": [column.effect for column in columns],
            "value": estimate.theta,
            "unit": [column.unit for column in columns],
            "standard_error": estimate.standard_errors,
            "low": estimate.theta - half,
            "high": estimate.theta + half,
        },
        index=pd.Index([column.name for column in columns], name="parameter"),
    )


def value_figure(estimate: EstimatedModel) -> Any:
    """A matplotlib figure of the parameters that are identified one by one, each effect with its 95 % intervals."""
    from matplotlib.figure import Figure

    names = [column.name for column in estimate.model.columns]
    alone = np.flatnonzero(np.isfinite(estimate.standard_errors))
    if not len(alone):
        raise InputError("no parameter is identified alone, only sums of them; print the estimate to see these")
    half = t_quantile(estimate.blocks) * estimate.standard_errors
    groups: dict[tuple[str, str], list[int]] = {}
    for index in alone:
        column = estimate.model.columns[index]
        groups.setdefault((column.effect, column.unit), []).append(int(index))
    sizes = [len(group) + 2 for group in groups.values()]
    figure = Figure(figsize=(7, ROW * sum(sizes) + 0.5), layout="constrained")
    panels = figure.subplots(len(groups), 1, squeeze=False, gridspec_kw={"height_ratios": sizes})[:, 0]
    for panel, ((effect, unit), group) in zip(panels, groups.items(), strict=True):
        places = np.arange(len(group))[::-1]
        panel.errorbar(estimate.theta[group], places, xerr=half[group], fmt="o", markersize=4, capsize=3)
        panel.set_yticks(places, [names[i] for i in group])
        panel.set_ylim(-0.7, len(group) - 0.3)
        panel.set_title(f"{effect.replace('_', ' ')} [{unit}]", loc="left", fontsize="medium")
    return figure
