"""Messages of joint states, whose joints have names, as a table: a message is a row as soon as it has arrived."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.large_arrays import Growing, blocks, empty, numbered
from physident.recordings.channels import BadRow, printable
from physident.recordings.columns.joint_names import joint_order, listed
from physident.recordings.formats.table import Table

Array = NDArray[np.float64]
Names = tuple[str, ...]
CHANNELS = {"q": "position", "dq": "velocity", "effort": "effort"}
MANY = 10  # messages of the same names: beside them, a single one of other names is no second arm and no gripper
MOST_GROUPS = 10_000  # different lists of names: more are no robot's
BATCH = 4096  # messages that become rows together
HEAD = 3  # columns before the channels: number in the topic from 1, time of arrival [s], stamp of the header [s]


class _Group:
    """The messages that name the same joints in the same order."""

    def __init__(self, names: Names) -> None:
        self.names, self.count, self.first, self.stamps = names, 0, 0, set[int]()
        self.bad: list[BadRow] = []
        self._rows, self._recent = Growing(HEAD + len(CHANNELS) * len(names)), list[Array]()
        self._table: Array | None = None

    def add(self, number: int, arrival: int, message: Any) -> None:
        self.first, self.count = self.first or number, self.count + 1
        stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
        if len(self.stamps) < 2:  # whether they stand still is all that is asked
            self.stamps.add(stamp)
        n = len(self.names)
        sizes = [len(getattr(message, channel)) for channel in CHANNELS.values()]
        if any(size not in (0, n) for size in sizes):
            self.bad.append(BadRow(number, f"{n} names, but {sizes} positions, velocities and efforts"))
            return
        row = np.full(HEAD + len(CHANNELS) * n, np.nan)
        row[:HEAD] = number, arrival / 1e9, stamp / 1e9
        for k, (channel, size) in enumerate(zip(CHANNELS.values(), sizes, strict=True)):
            if size:
                row[HEAD + k * n : HEAD + (k + 1) * n] = getattr(message, channel)
        self._recent.append(row)
        if len(self._recent) == BATCH:
            self._rows.add(np.array(self._recent))
            self._recent = []

    @property
    def table(self) -> Array:
        """Number, arrival, stamp and channels (N, 3 + 3 n) of the messages."""
        if self._table is None:
            if self._recent:
                self._rows.add(np.array(self._recent))
            self._table, self._recent = self._rows.table(), []
        return self._table


class JointStates:
    """Joint states as they arrive: rows for each list of names, which lie in a temporary file where they are many."""

    def __init__(self, source: str) -> None:
        self._source, self._groups = source, dict[Names, _Group]()

    def add(self, number: int, arrival: int, message: Any) -> None:
        """Add a message by its number in the topic, from 1, and its time of arrival [ns]."""
        names = tuple(message.name)
        if names not in self._groups:
            if len(self._groups) == MOST_GROUPS:
                raise InputError(
                    f"{self._source}: its messages name joints in over {MOST_GROUPS} ways; expected those of one robot"
                )
            self._groups[names] = _Group(names)
        self._groups[names].add(number, arrival, message)

    def table(self, wanted: Sequence[str] | None, broken: Sequence[BadRow]) -> Table:
        """The table of one arm, of at least one message; ``broken`` are messages that could not be read.

        Raises InputError as ``read_rosbag``.
        """
        groups, strays = self._without_strays()
        names = _joints_of([group.names for group in groups], wanted, self._source)
        kept = [group for group in groups if set(names) <= set(group.names)]
        orders = [[group.names.index(joint) for joint in names] for group in kept]
        present = self._present(kept, orders)
        width, clock = len(names), 1 if len(set.union(*(group.stamps for group in kept))) == 1 else 2
        tables = [group.table for group in kept]
        count = sum(map(len, tables))
        values, rows = empty((count, 1 + width * len(present))), empty(count, np.intp)
        for table, group, order, places in zip(tables, kept, orders, _places(tables), strict=True):
            n = len(group.names)
            chosen = [clock, *(HEAD + list(CHANNELS).index(name) * n + j for name in present for j in order)]
            for block in blocks(len(table)):
                some = table[block]
                values[places[block]] = some[:, chosen]
                rows[places[block]] = some[:, 0].astype(np.intp)
        rejected = [*broken, *strays, *(bad for group in kept for bad in group.bad)]
        return Table(
            values,
            rows,
            ("time", *(f"{name}_{j}" for name in present for j in range(1, width + 1))),
            tuple(sorted(rejected, key=lambda bad: bad.row)),
            joints=tuple(map(printable, names)),
        )

    def _without_strays(self) -> tuple[list[_Group], list[BadRow]]:
        """The groups without lists of names that a single message has, beside many that agree: its names are damaged."""
        groups = list(self._groups.values())
        most = max(group.count for group in groups)
        strays = [group for group in groups if group.count == 1 and most >= MANY]
        usual = {name for group in groups if group not in strays for name in group.names}
        bad = []
        for group in strays:
            others = [name for name in group.names if name not in usual]
            why = f"names joints as no other message does ({listed(others) or 'another order'})"
            bad.append(BadRow(group.first, why))
        return [group for group in groups if group not in strays], bad

    def _present(self, groups: Sequence[_Group], orders: Sequence[list[int]]) -> list[str]:
        """The channels that some message has; raises InputError without position or effort."""

        def is_there(channel: int) -> bool:
            for group, order in zip(groups, orders, strict=True):
                places = [HEAD + channel * len(group.names) + j for j in order]
                if not all(np.isnan(group.table[rows][:, places]).all() for rows in blocks(len(group.table))):
                    return True
            return False

        present = [name for channel, name in enumerate(CHANNELS) if is_there(channel)]
        if "effort" not in present or "q" not in present:
            missing = "effort" if "effort" not in present else "position"
            raise InputError(
                f"{self._source}: its joint states have no {missing}; expected position and effort of every joint"
            )
        return present


def _places(tables: Sequence[Array]) -> list[NDArray[np.intp]]:
    """The row of each message of each table in the order of the messages' numbers."""
    if len(tables) == 1:
        return [numbered(len(tables[0]), 0)]
    ranks = np.argsort(np.argsort(np.concatenate([table[:, 0] for table in tables])))
    return np.split(ranks, np.cumsum([len(table) for table in tables])[:-1])


def _joints_of(groups: Sequence[Names], joints: Sequence[str] | None, source: str) -> Names:
    """The names of one arm: those that stand for ``joints``, or those of all messages where these name the same ones."""
    for names in groups:
        if len(set(names)) < len(names) or not names:
            raise InputError(f"{source}: a message names no joint, or one twice ({listed(names)}); expected each once")
    first, *others = groups
    every = sorted({name for names in groups for name in names})
    if joints is None:
        if any(set(names) != set(first) for names in others):
            raise InputError(
                f"{source}: its messages name different joints in turn ({listed(every)}); expected those of one arm:"
                " choose the robot (--robot, or joints=robot.joint_names)"
            )
        return first
    arms = {
        tuple(names[j] for j in order) for names in groups if (order := _fitting(names, joints, source)) is not None
    }
    if len(arms) == 1:
        return arms.pop()
    joint_order(every, joints, source)  # raises where joints are missing or two arms have them
    raise InputError(f"{source}: no message names all of {listed(joints)}; expected them in one message")


def _fitting(names: Sequence[str], joints: Sequence[str], source: str) -> list[int] | None:
    try:
        return joint_order(names, joints, source)
    except InputError:
        return None
