"""What has changed in a fleet as plain numbers and texts."""

from __future__ import annotations

from typing import Any

from physident.fleet.drift.alarms import Alarm, Drift


def drift_as_dict(drift: Drift) -> dict[str, Any]:
    """The arms that need attention, those that are watched, and the files that cannot be used."""
    return {
        "false_alarms_per_arm_and_year": drift.rate,
        "arms": drift.arms,
        "young": list(drift.young),
        "alarms": [_alarm(alarm) for alarm in drift.alarms],
        "broken": [vars(one) for one in drift.broken],
    }


def _alarm(alarm: Alarm) -> dict[str, Any]:
    return {
        "arm": alarm.arm,
        "day": str(alarm.day),
        "clearest": str(alarm.clearest),
        "since": str(alarm.since),
        "cause": alarm.words,
        "effect": alarm.effect,
        "joint": alarm.joint,
        "parameter": alarm.shown.history.parameter,
        "unit": alarm.shown.history.unit,
        "shift": alarm.shift,
        "std": alarm.std,
        "strength": alarm.strength,
        "limit": alarm.limit,
        "rivals": list(alarm.rivals),
        "forecast": None if alarm.trend is None else vars(alarm.trend),
    }
