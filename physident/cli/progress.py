"""What a verb shows of its progress on standard error: a bar in a terminal, elsewhere a line now and then."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from rich.progress import Progress

T = TypeVar("T")
PATIENCE = 2.0  # s before a bar appears
BETWEEN_LINES = 20.0  # s between lines where there is no terminal


class _Display:
    """The progress of one activity; ``share`` is None where its steps cannot be counted."""

    def __init__(self, activity: str, share: float | None) -> None:
        self.activity, self.share = activity, share
        self.start = self.last_line = time.monotonic()
        self.bar: Progress | None = None

    def update(self, share: float | None) -> None:
        """Show the share that is done, where it is time to show anything."""
        self.share = share
        now = time.monotonic()
        if not sys.stderr.isatty():
            if now - self.last_line > BETWEEN_LINES:
                self.last_line = now
                done = "" if share is None else f", {100 * share:.0f} % done"
                print(f"physident: {self.activity}{done}, {now - self.start:.0f} s", file=sys.stderr, flush=True)
        elif self.bar is not None:
            self.bar.update(self.bar.task_ids[0], completed=None if share is None else 100 * share)
        elif now - self.start > PATIENCE:
            self._open()

    def say(self, text: str) -> None:
        """Print a line above the bar."""
        print(f"physident: {text}", file=sys.stderr, flush=True)

    def close(self) -> None:
        """Take the bar away."""
        if self.bar is not None:
            self.bar.stop()

    def _open(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, SpinnerColumn, TaskProgressColumn, TextColumn, TimeElapsedColumn

        counted = (BarColumn(), TaskProgressColumn()) if self.share is not None else (SpinnerColumn(),)
        columns = (TextColumn("{task.description}"), *counted, TimeElapsedColumn())
        bar = Progress(*columns, console=Console(stderr=True), transient=True)
        bar.add_task(self.activity, total=None if self.share is None else 100, completed=int(100 * (self.share or 0)))
        bar.start()
        self.bar = bar


def progress(items: Iterable[T], activity: str) -> Iterator[T]:
    """The items, with the share of them that is done."""
    listed = list(items)
    with share_done(activity) as show:
        for index, item in enumerate(listed):
            show(index / len(listed))
            yield item


@contextmanager
def share_done(activity: str) -> Iterator[Callable[[float], None]]:
    """Shows an activity; to be called with the share of it that is done."""
    display = _Display(activity, 0.0)
    try:
        yield display.update
    finally:
        display.close()


@contextmanager
def busy(activity: str) -> Iterator[Callable[[str], None]]:
    """A clock for work whose steps cannot be counted; to be called with a text to print a line."""
    display, stopped = _Display(activity, None), threading.Event()

    def tick() -> None:
        while not stopped.wait(0.5):
            display.update(None)

    thread = threading.Thread(target=tick, daemon=True)
    thread.start()
    try:
        yield display.say
    finally:
        stopped.set()
        thread.join()
        display.close()
