"""The parts of a report: numbers that keep their value, curves that keep their extremes, JSON that keeps its types."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from physident.diagnosis.remainder.in_words import remainder_sentence
from physident.diagnosis.result.wording import curves_in_brief, headline, in_words, listed, numbered
from physident.report.chart import BINS, HEIGHT, WIDTH, Line, line_chart, ticks
from physident.report.markup import joined, tag
from physident.report.numbers import number, percent, quantity
from tests.page import Element, read_page

POWERS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


def value_of(text: str) -> float:
    """The number that a text shows."""
    mantissa, _, power = text.replace("−", "-").partition("·10")
    return float(mantissa) * 10.0 ** (int(power.translate(POWERS)) if power else 0)


@given(st.floats(-1e300, 1e300, allow_subnormal=False))
def test_a_shown_number_is_within_half_a_digit_of_the_true_one(x: float) -> None:
    shown = number(x)
    assert value_of(shown) == pytest.approx(x, rel=5.1e-3, abs=1e-300)
    assert len(shown) <= 13
    assert "e" not in shown
    assert number(-abs(x)).startswith("−") or x == 0


def test_percentages_units_and_signs() -> None:
    assert [percent(x).replace("\N{NO-BREAK SPACE}", " ") for x in (0.0, -0.04, 4.96, 9.96, 57.2)] == [
        "0.0 %", "0.0 %", "5.0 %", "10 %", "57 %",
    ]  # fmt: skip
    assert percent(-57.2, sign=True).startswith("−57")
    assert percent(3.0, sign=True).startswith("+3.0")
    shown = quantity(2.0, "kg m^2").replace("\N{NO-BREAK SPACE}", " ")
    assert shown == "2.00 kg m²"
    assert quantity(0.08, "1") == "0.0800"


def curves(lines: list[Line], **options: Any) -> tuple[Element, list[np.ndarray]]:
    chart = read_page(line_chart(lines, "N m", "torque", **options))
    points = [line.attributes["points"].split() for line in chart.all("polyline")]
    return chart, [np.array([[float(x) for x in point.split(",")] for point in line]) for line in points]


def test_a_long_series_keeps_every_peak_and_a_short_one_every_sample() -> None:
    time = np.arange(60_000) / 100
    values = np.sin(0.3 * time)
    peaks = np.random.default_rng(0).choice(len(time), 40, replace=False)
    values[peaks] = 3.0
    _, (drawn,) = curves([Line("x", time, values, "#000")])
    assert len(drawn) < 2000
    top = drawn[:, 1].min()  # the drawing's axis points down
    places = set(drawn[drawn[:, 1] == top][:, 0])
    for peak in peaks:
        assert min(abs(place - WIDTH * time[peak] / time[-1]) for place in places) <= WIDTH / BINS + 1
    _, (short,) = curves([Line("x", time[:300], values[:300], "#000")])
    assert len(short) == 300


def test_a_pause_of_the_clock_breaks_the_line_and_all_stays_inside() -> None:
    time = np.concatenate([np.arange(50) / 20, 10 + np.arange(50) / 20])
    chart, drawn = curves([Line("x", time, np.cos(time), "#000")], bands=[(1.0, 2.0), (30.0, 40.0)])
    assert len(drawn) == 2
    points = np.concatenate(drawn)
    assert points.min() >= 0
    assert points[:, 0].max() <= WIDTH
    assert points[:, 1].max() <= HEIGHT
    assert len(chart.all("rect")) == 1  # the other band lies outside


def test_a_constant_series_is_drawn() -> None:
    _, (drawn,) = curves([Line("x", np.arange(10.0), np.zeros(10), "#000")])
    assert np.ptp(drawn[:, 1]) == 0


@given(st.floats(-1e3, 1e3), st.integers(-12, 9))
def test_ticks_are_round_even_and_inside(place: float, power: int) -> None:
    size = 10.0**power
    low = place * size
    marks = ticks(low, low + size, 4)
    assert 1 <= len(marks) <= 9
    steps = np.diff(marks)
    np.testing.assert_allclose(steps, steps[0] if len(steps) else 1.0, rtol=1e-4)
    assert low - 1e-6 * size <= marks[0]
    assert marks[-1] <= low + (1 + 1e-6) * size


@given(st.text())
def test_no_text_becomes_an_element_or_leaves_its_attribute(text: str) -> None:
    page = read_page(tag("p", text, class_=text))
    assert len(page.inside) == 1
    (p,) = page.all("p")
    assert all(isinstance(child, str) for child in p.inside)
    assert set(p.attributes) == {"class"}
    assert joined(text).isprintable() or "\n" in text or "\xa0" in text


def test_joints_and_effects_read_as_sentences() -> None:
    assert numbered([6, 1, 2, 3]) == "1 to 3 and 6"
    assert numbered([1, 2]) == "1 and 2"
    assert listed(["a", "b", "c"]) == "a, b and c"
    assert (
        in_words("stribeck_friction: not load_dependent_friction") == "Stribeck friction: not load-dependent friction"
    )
    assert headline("different", "nothing_missing", ()).startswith("Nothing is different")
    assert headline("nominal", "unexplained", ()).startswith(
        "These recordings prove nothing that is wrong with the nominal model"
    )


def replace_gain(finding: Any, interval: tuple[float, float]) -> Any:
    return SimpleNamespace(**{**vars(finding), "gain": SimpleNamespace(interval95=interval)})


def test_what_is_proved_and_is_no_cause_is_said_in_the_headline() -> None:
    """Only where no finding is a cause; what is doubted, or left-out rows may be predicted as well without, is never said there."""
    findings: Any = (
        SimpleNamespace(
            effect=effect,
            joints=joints,
            grade=grade,
            intervals=(),
            rivals=rivals,
            gain=SimpleNamespace(interval95=(1, 2)),
        )
        for effect, joints, grade, rivals in (
            ("time_delay", (), "contribution", [SimpleNamespace(effect="payload", joints=(), inseparable=False)]),
            ("payload", (), "hint", ()),
            ("joint_spring", (2,), "cause", ()),
        )
    )
    part, doubted, found = findings
    said = headline("missing", "unexplained", [part, doubted])
    assert said == (
        "Found to be missing from the model, but not as the main cause of the error: time delay or payload."
    )
    part.rivals.extend([SimpleNamespace(effect="joint_spring", joints=(j,), inseparable=False) for j in (1, 2)])
    assert headline("missing", "unexplained", [part]).endswith(
        "time delay or payload or joint spring on joint 1 or others."
    )
    assert headline("missing", "unexplained", [doubted]) == headline("missing", "unexplained", ())
    unproved = replace_gain(part, (-0.1, 3.0))
    assert headline("missing", "unexplained", [unproved]) == headline("missing", "unexplained", ())
    assert "time delay" not in headline("missing", "explained", [part, found])


def test_what_a_cause_may_also_be_is_said_in_the_headline() -> None:
    """Who reads no further must not take one of several names for the answer."""
    names = ("torque_constant", "viscous_friction", "coulomb_friction", "payload")
    rivals = [SimpleNamespace(effect=name, joints=(6,), inseparable=False) for name in names[1:]]
    found: Any = SimpleNamespace(effect=names[0], joints=(6,), grade="cause", intervals=(), rivals=rivals)
    assert headline("different", "explained", [found]).endswith(
        "torque constant on joint 6 or viscous friction on joint 6 or Coulomb friction on joint 6 or others."
    )


def test_what_is_left_is_said_beside_what_it_was_left_of() -> None:
    part: Any = SimpleNamespace(grade="contribution", intervals=(), gain=SimpleNamespace(interval95=(1, 2)))
    plain, old, compared = (
        remainder_sentence("nothing_missing", (), *how) for how in ((False, False), (True, False), (False, True))
    )
    assert plain == "No effect of the catalogue beats chance, and the remaining residual is noise."
    assert "lacked before" in old
    assert "comparison" in compared
    assert remainder_sentence("nothing_missing", [part], True, False) == "The remaining residual is noise."
    assert "comparison" in remainder_sentence("explained", (), False, True)
    alone, beside = (remainder_sentence("unexplained", some, False, False) for some in ((), [part]))
    assert "beside it" in beside
    assert "beside it" not in alone


def test_curves_are_told_in_brief_without_the_laws_near_them() -> None:
    words = "joint 2: a torque that depends on the load, +10 N m between 76 and 90 N m; nearest: viscous_friction, 44 % of it."
    one: Any = SimpleNamespace(joints=(2,), in_words=words)
    assert curves_in_brief(one) == "a torque that depends on the load, +10 N m between 76 and 90 N m"
    both: Any = SimpleNamespace(joints=(2, 3), in_words=f"{words} {words.replace('joint 2', 'joint 3')}")
    assert curves_in_brief(both).count("depends on the load") == 2
    assert "; joint 3: a torque" in curves_in_brief(both)
    assert "viscous" not in curves_in_brief(both)
