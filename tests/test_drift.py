"""Changes in the histories of a fleet: found where they are, at the stated rate where they are not."""

from __future__ import annotations

from datetime import date, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from physident.cli import run
from physident.errors import InputError
from physident.fleet.dataset import write_rows
from physident.fleet.drift.alarms import Drift, find_drift
from physident.fleet.drift.conditions import REFERENCE
from physident.fleet.drift.forecast import AHEAD, forecast
from physident.fleet.drift.threshold import Chance, limit, shifts, windows

Array = np.ndarray
START = date(2024, 1, 1)
STD = 0.05
NAMES = {"viscous_friction_1": ("viscous_friction", 1), "coulomb_friction_2": ("coulomb_friction", 2)}


def autocorrelated(rng: np.random.Generator, shape: tuple[int, ...], memory: float) -> Array:
    """Noise (..., N) of unit variance whose values remember the one before."""
    steps = rng.normal(size=shape)
    z = np.empty_like(steps)
    z[..., 0] = steps[..., 0]
    for i in range(1, shape[-1]):
        z[..., i] = memory * z[..., i - 1] + np.sqrt(1 - memory**2) * steps[..., i]
    return z


def fleet(folder: Path, changes: dict[str, Array], temperature: Array) -> Path:
    """A data set with the changes (arms, N) of each parameter at temperatures (arms, N) [degC], a recording every ten days."""
    arms, count = temperature.shape
    for arm in range(arms):
        for k in range(count):
            day = START + timedelta(days=10 * k)
            common = {"arm": f"arm_{arm}", "day": day, "file": f"{arm}/{day}", "hash": f"{arm}_{k}"}
            rows: list[dict[str, Any]] = [
                {
                    **common,
                    "parameter": name,
                    "effect": NAMES[name][0],
                    "joint": NAMES[name][1],
                    "unit": "N m",
                    "value": 5 + x[arm, k],
                    "change": x[arm, k],
                    "std": STD,
                    "low": 5 + x[arm, k] - 2 * STD,
                    "high": 5 + x[arm, k] + 2 * STD,
                    "baseline": 5.0,
                    "information": STD**-2,
                    "blocks": 20.0,
                    "temperature": temperature[arm, k],
                    "load": 10.0,
                    "seconds": 20.0,
                    "coupling": [STD**-2],
                }
                for name, x in changes.items()
            ]
            (folder / "rows").mkdir(parents=True, exist_ok=True)
            write_rows(folder / "rows" / f"{arm}_{k}.parquet", rows)
    return folder


def drawn(seed: int, arms: int, count: int, memory: float = 0.0) -> tuple[dict[str, Array], Array]:
    """Histories without a change, which follow the temperature."""
    rng = np.random.default_rng(seed)
    temperature = 22 + 6 * np.sin(np.arange(count) * 10 / 365 * 2 * np.pi) + rng.normal(0, 2, (arms, count))
    changes = {
        name: STD * autocorrelated(rng, (arms, count), memory) - slope * (temperature - 22)
        for name, slope in zip(NAMES, (0.05, 0.02), strict=True)
    }
    return changes, temperature


@pytest.mark.parametrize("memory", [0.0, 0.6])
@pytest.mark.parametrize("count", [20, 60])
def test_chance_exceeds_the_limit_as_often_as_stated(count: int, memory: float) -> None:
    z = autocorrelated(np.random.default_rng(5), (4000, count), memory)
    z = z - z[:, :REFERENCE].mean(axis=1, keepdims=True)
    largest = np.abs(shifts(z, np.full_like(z, REFERENCE**-0.5))).max(axis=(0, 2))
    for probability in (0.05, 0.01):
        share = (largest > limit(count, Chance(memory, 1e6), probability)).mean()
        assert share == pytest.approx(probability, abs=4 * np.sqrt(probability / 4000))


@pytest.mark.parametrize("memory", [0.0, 0.5])
@pytest.mark.slow
def test_histories_without_a_change_alarm_no_more_often_than_stated(tmp_path: Path, memory: float) -> None:
    """Forty arms over two years at a rate of 0.1: eight false alarms at most are expected."""
    drift = find_drift(fleet(tmp_path, *drawn(6, 40, 73, memory)), rate=0.1)
    years = 40 * (73 - REFERENCE) * 10 / 365.25
    assert len(drift.alarms) <= 0.1 * years + 3 * np.sqrt(0.1 * years)
    assert len(drift.arms) == 40


@pytest.fixture(scope="module")
def changed(tmp_path_factory: pytest.TempPathFactory) -> Drift:
    """Arm 3 from the 30th recording on with a step, arm 7 with a trend of 0.004 N m a day."""
    changes, temperature = drawn(8, 12, 60)
    changes["viscous_friction_1"][3, 30:] += 6 * STD
    changes["coulomb_friction_2"][7, 30:] += 0.004 * 10 * np.arange(30)
    return find_drift(fleet(tmp_path_factory.mktemp("changed"), changes, temperature))


def test_a_step_and_a_trend_are_found_with_their_place(changed: Drift) -> None:
    alarms = {alarm.arm: alarm for alarm in changed.alarms}
    assert set(alarms) == {"arm_3", "arm_7"}
    begun = START + timedelta(days=300)
    assert (alarms["arm_3"].effect, alarms["arm_3"].joint) == ("viscous_friction", 1)
    assert (alarms["arm_7"].effect, alarms["arm_7"].joint) == ("coulomb_friction", 2)
    assert begun <= alarms["arm_3"].day <= begun + timedelta(days=20)
    assert abs((alarms["arm_3"].since - begun).days) <= 10
    assert begun <= alarms["arm_7"].day <= begun + timedelta(days=90)
    assert alarms["arm_3"].trend is None


def test_a_trend_is_continued_with_an_interval_that_holds_the_truth(changed: Drift) -> None:
    trend = next(alarm.trend for alarm in changed.alarms if alarm.arm == "arm_7")
    assert trend is not None
    assert trend.slope == pytest.approx(0.004 * 365.25, rel=0.1)
    assert trend.low < 0.004 * (290 + AHEAD) < trend.high
    assert trend.high - trend.low < 10 * STD


def test_temperature_is_explained_away(changed: Drift) -> None:
    sound = [one for one in changed.histories if one.history.arm == "arm_0"]
    slopes = {one.history.parameter: one.slopes[one.conditions.index("temperature")] for one in sound}
    assert slopes["viscous_friction_1"] == pytest.approx(-0.05, abs=0.004)
    assert slopes["coulomb_friction_2"] == pytest.approx(-0.02, abs=0.004)
    for one in sound:
        assert np.std(one.rest) < 1.5 * STD
        assert np.median(one.size) == pytest.approx(STD, rel=0.3)


def test_forecasts_hold_the_truth_as_often_as_they_say() -> None:
    rng, day, held, given = np.random.default_rng(9), np.arange(0.0, 200, 10), 0, 0
    for _ in range(400):
        found = forecast(day, 0.002 * day + STD * rng.normal(size=len(day)), np.full(len(day), STD))
        if found is not None:
            given += 1
            seen = 0.002 * (day[-1] + AHEAD) + STD * rng.normal()  # a recording then
            held += found.low < seen < found.high
    assert given > 350
    assert 0.92 <= held / given <= 0.995
    assert forecast(day[:3], day[:3], np.ones(3)) is None


def test_windows_grow_and_end_with_the_history() -> None:
    assert windows(13) == [1, 2, 3, 5, 8, 13]
    assert windows(1) == [1]


def logged(session: Path) -> dict[str, Array]:
    """The curves in a session, by their entities."""
    from rerun.chunk import RrdReader

    found: dict[str, list[float]] = {}
    for chunk in RrdReader(str(session)).stream():
        batch = chunk.to_record_batch()
        for label, column in zip(batch.schema.names, batch.columns, strict=True):
            if label.endswith("Scalars:scalars"):
                values = [float(value[0]) for value in column.to_pylist() if value]
                found.setdefault(str(chunk.entity_path), []).extend(values)
    return {path: np.array(values) for path, values in found.items()}


def test_page_and_json_of_a_fleet(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    changes, temperature = drawn(10, 6, 30)
    changes["viscous_friction_1"][2, 15:] += 8 * STD
    folder = fleet(tmp_path / "fleet", changes, temperature)
    write_rows(
        folder / "rows" / "bad.parquet",
        [{"arm": "arm_1", "day": START, "file": "bad.csv", "hash": "x", "error": "<no> rows"}],
    )
    page, record = tmp_path / "fleet.html", tmp_path / "drift.json"
    session = tmp_path / "fleet.rrd"
    assert run(["drift", str(folder), "--session", str(session)]) == 0
    found = logged(session)
    assert len(found["/shifts/arm_0"]) == 30 - REFERENCE
    assert len(found["/arms/arm_2/cause/rest"]) == len(found["/arms/arm_2/temperature"]) == 30
    np.testing.assert_allclose(found["/arms/arm_2/temperature"], temperature[2])
    assert "/arms/arm_1/cause/rest" not in found
    assert run(["drift", str(folder), "--page", str(page), "--json", str(record)]) == 0
    assert run(["drift", str(folder), "--page", str(page), "--json", str(record)]) == 0  # replaces what it wrote
    text = page.read_text(encoding="utf-8")
    assert "1 of 6 arms need attention" in text
    assert "arm_2" in text
    assert "data:image/png" in text
    assert "&lt;no&gt; rows" in text
    assert '"cause": "friction of joint 1 (viscous part)"' in record.read_text(encoding="utf-8")
    assert "1 need attention" in capfd.readouterr().out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["nowhere"], "has no results of a fleet"),
        (["nowhere", "--false-alarms", "0"], "rate of false alarms"),
        (["nowhere", "--page", "x.txt"], "ends in .html"),
        (["nowhere", "--session", "x.txt"], "ends in .rrd"),
        (["nowhere", "--until", "2026-13-01"], "2026-13-01"),
    ],
)
def test_bad_input_is_one_line(words: list[str], said: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert run(["drift", *words]) == 2
    err = capfd.readouterr().err
    assert said in err
    assert err.count("\n") == 1


def test_too_short_a_history_is_not_watched(tmp_path: Path) -> None:
    drift = find_drift(fleet(tmp_path, *drawn(11, 2, REFERENCE)))
    assert drift.young == ("arm_0", "arm_1")
    assert not drift.alarms
    with pytest.raises(InputError, match="has no results"):
        find_drift(tmp_path / "rows")


def hours(folder: Path, seed: int, clocks: bool) -> Path:
    """Six arms without a thermometer, in 30 days each recorded for ten minutes one to four hours after they started, and longer
    ones before, whose friction falls by 8 standard deviations as they warm up; ``clocks`` count from the day's start."""
    rng = np.random.default_rng(seed)
    (folder / "rows").mkdir(parents=True)
    for arm in range(6):
        for k in range(30):
            begun, day = 0.0, START + timedelta(days=10 * k)
            for part, seconds in enumerate(rng.uniform(300, 4000, rng.integers(1, 4)).tolist()):
                times = np.linspace(begun, begun + seconds, 200)
                change = 8 * STD * float(np.exp(-times / 3600).mean()) + STD * rng.normal()
                row = {
                    "arm": f"arm_{arm}", "day": day, "file": f"{arm}/{day}/{part}", "hash": f"{arm}_{k}_{part}",
                    "parameter": "viscous_friction_1", "effect": "viscous_friction", "joint": 1, "unit": "N m s/rad",
                    "value": 5 + change, "change": change, "std": STD, "low": 0.0, "high": 9.0, "baseline": 5.0,
                    "information": STD**-2, "blocks": 20.0, "temperature": None, "load": 10.0, "seconds": seconds,
                    "start": 1e9 + 864000 * k + begun if clocks else 0.0, "coupling": [STD**-2],
                }  # fmt: skip
                write_rows(folder / "rows" / f"{row['hash']}.parquet", [row])
                begun += seconds
    return folder


@pytest.mark.parametrize("clocks", [True, False])
def test_warm_up_since_the_start_of_a_day_is_explained_away(tmp_path: Path, clocks: bool) -> None:
    drift = find_drift(hours(tmp_path, 12, clocks))
    assert not drift.alarms
    for one in drift.histories:
        assert one.conditions == ("warm-up in 10 min", "warm-up in 60 min")
        assert one.slopes[1] == pytest.approx(-8 * STD, rel=0.35)
        assert np.std(one.history.change) > 1.5 * STD
        assert np.std(one.rest) < 1.2 * STD


def test_later_recordings_are_not_looked_at(tmp_path: Path) -> None:
    changes, temperature = drawn(13, 6, 40)
    changes["viscous_friction_1"][2, 30:] += 8 * STD
    folder = fleet(tmp_path, changes, temperature)
    begun = START + timedelta(days=300)
    assert not find_drift(folder, until=begun - timedelta(days=1)).alarms
    (alarm,) = find_drift(folder, until=begun + timedelta(days=20)).alarms
    assert (alarm.arm, alarm.effect) == ("arm_2", "viscous_friction")
    assert alarm.clearest == begun + timedelta(days=20)


def test_the_cause_is_that_of_the_clearest_recordings(tmp_path: Path) -> None:
    """A parameter that jumps for one recording, and months later another one that stays changed."""
    changes, temperature = drawn(14, 20, 40)
    changes["coulomb_friction_2"][4, 12] += 12 * STD
    changes["viscous_friction_1"][4, 30:] += 9 * STD
    (alarm,) = find_drift(fleet(tmp_path, changes, temperature)).alarms
    assert alarm.day == START + timedelta(days=120)
    assert (alarm.effect, alarm.joint) == ("viscous_friction", 1)
    assert abs((alarm.since - START).days - 300) <= 10
    assert alarm.clearest > START + timedelta(days=310)
