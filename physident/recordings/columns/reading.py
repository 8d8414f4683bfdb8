"""How files are read that do not say it themselves: columns, topic, rate, names of the joints. One text holds it all."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from physident.errors import InputError
from physident.recordings.columns.layout import ColumnLayout

SETTINGS = ("topic", "rate", "joints")


@dataclass(frozen=True, kw_only=True)
class Reading:
    """How to read a recording's file; None leaves a choice to the file.

    ``columns`` is a column layout or its text, ``topic`` that of a bag, ``rate`` [Hz] that of rows without a clock,
    ``joints`` the names of the robot's joints, for files that name theirs; ``declared_joints`` the file's names of these
    joints, in the order of the robot, where they are others.
    """

    columns: str | ColumnLayout | None = None
    topic: str | None = None
    rate: float | None = None
    joints: tuple[str, ...] | None = None
    declared_joints: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        if isinstance(self.columns, str):
            ColumnLayout.check(self.columns)
        if self.rate is not None and not (isinstance(self.rate, int | float) and 0 < self.rate <= 1e6):
            raise InputError(f"rate is {self.rate!r}, expected the rows' frequency [Hz], above 0 and up to 1e6")

    @property
    def wanted_joints(self) -> tuple[str, ...] | None:
        """The names in the file of the joints that are wanted, in the order of the robot; None where they are not known."""
        return self.declared_joints or self.joints

    @property
    def text(self) -> str | None:
        """The text from which ``parse`` reads what is declared; None where nothing is, or where the columns have no text."""
        if isinstance(self.columns, ColumnLayout):
            return None
        given = {"topic": self.topic, "rate": self.rate and f"{self.rate:.12g}"}
        given["joints"] = self.declared_joints and " ".join(self.declared_joints)
        return ",".join([self.columns or "", *(f"{k}={v}" for k, v in given.items() if v)]).removeprefix(",") or None

    @staticmethod
    def parse(text: str) -> Reading:
        """From a text such as "q=0:6,tau=6:12,rate=125" or "topic=/joint_states,joints=a b c"; raises InputError for another one."""
        if not isinstance(text, str):
            ColumnLayout.check(text)
        settings: dict[str, str] = {}
        columns: list[str] = []
        for part in text.split(","):
            name, _, value = (piece.strip() for piece in part.partition("="))
            if name not in SETTINGS:
                columns.append(part)
            elif name in settings or not value:
                raise InputError(f"columns: {part!r} is empty or given twice; expected one value, as in rate=125")
            else:
                settings[name] = value
        return Reading(
            columns=",".join(columns) if columns else None,
            topic=settings.get("topic"),
            rate=_rate(settings["rate"]) if "rate" in settings else None,
            declared_joints=tuple(settings["joints"].split()) if "joints" in settings else None,
        )


def reading_text(
    columns: str | None, topic: str | None, rate: float | None, remembered: str | None = None
) -> str | None:
    """One text for ``Reading.parse`` of three options; those that are None are taken from a ``remembered`` text.

    Raises InputError for a topic that is no name, and for a rate that is no frequency [Hz].
    """
    if topic is not None and not re.fullmatch(r"[\w/~{}.:-]+", topic):
        raise InputError(f"topic is {topic!r}, expected the name of a topic, such as /joint_states")
    if rate is not None and not math.isfinite(rate):
        raise InputError(f"rate is {rate!r}, expected the rows' frequency [Hz]")
    before = [part for part in (remembered or "").split(",") if part]
    old = {name: [p for p in before if p.partition("=")[0].strip() == name] for name in SETTINGS}
    layout = [p for p in before if p.partition("=")[0].strip() not in SETTINGS]
    parts = [columns] if columns is not None else layout
    parts += [f"topic={topic}"] if topic is not None else old["topic"]
    parts += [f"rate={rate:.12g}"] if rate is not None else old["rate"]
    parts += old["joints"] if columns is None else []
    text = ",".join(parts)
    if columns is not None or text:
        Reading.parse(text)
    return text if columns is not None or text else None


def _rate(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(f"columns: rate is {text!r}, expected the rows' frequency [Hz], as in rate=125") from None
