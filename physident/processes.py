"""Work on blocks of large arrays by as many processes as there are processors; the numbers are those of one process."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, TypeVar

from physident.errors import InputError

T = TypeVar("T")
R = TypeVar("R")
VARIABLE = "PHYSIDENT_PROCESSES"
_BUSY: ContextVar[bool] = ContextVar("_BUSY", default=False)  # while processes take turns, each of them works alone


def processors() -> int:
    """Number of processes to work with: the environment's ``PHYSIDENT_PROCESSES``, or the processors this program may use.

    Raises InputError for a variable that is no number.
    """
    given = os.environ.get(VARIABLE)
    if given is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)
    if not given.isdigit() or not 1 <= int(given) <= 1024:
        raise InputError(f"{VARIABLE} is {given!r}, expected a number of processes, such as 1 or 2")
    return int(given)


def mapped(function: Callable[[T], R], items: Sequence[T]) -> list[R]:
    """What a function returns for each item, in order; several processes take turns. An error of one process is raised here."""
    workers = min(processors(), len(items))
    if workers < 2 or not _can_fork():
        return [function(item) for item in items]
    fork = multiprocessing.get_context("fork")

    def work(first: int, channel: Any) -> None:
        try:
            with _busy():
                channel.send(([function(item) for item in items[first::workers]], None))
        except BaseException as caught:
            channel.send(([], caught))

    pipes = [fork.Pipe(duplex=False) for _ in range(1, workers)]
    started = [fork.Process(target=work, args=(k, end)) for k, (_, end) in enumerate(pipes, 1)]
    results: list[list[R]] = []
    try:
        for process, (_, end) in zip(started, pipes, strict=True):
            process.start()
            end.close()  # the other end's only holder is the process: it is closed when that ends
        with _busy():
            results.append([function(item) for item in items[::workers]])
        for process, (channel, _) in zip(started, pipes, strict=True):
            try:
                found, error = channel.recv()
            except EOFError:
                process.join()
                raise RuntimeError(f"a process of physident was ended from outside (code {process.exitcode})") from None
            if error is not None:
                raise error
            results.append(found)
    finally:
        for process in started:
            if process.pid is not None:
                process.terminate()
                process.join()
    return [results[k % workers][k // workers] for k in range(len(items))]


def _can_fork() -> bool:
    able = "fork" in multiprocessing.get_all_start_methods() and not multiprocessing.current_process().daemon
    return able and not _BUSY.get()


@contextmanager
def _busy() -> Iterator[None]:
    """Work during which no more processes are started: all processors have theirs."""
    token = _BUSY.set(True)
    try:
        yield
    finally:
        _BUSY.reset(token)


def each(function: Callable[[T], object], items: Sequence[T], shared: bool) -> None:
    """Call a function on every item, whose results go into arrays.

    Where the arrays are ``shared``, as those in files are, several processes take turns; else this one does all. An error of
    one process is raised here.
    """
    workers = min(processors(), len(items)) if shared else 1
    if workers < 2 or not _can_fork():
        for item in items:
            function(item)
        return
    fork = multiprocessing.get_context("fork")  # the arrays and the function are inherited, not sent
    channel = fork.SimpleQueue()

    def work(first: int) -> None:
        error: Any = None
        try:
            with _busy():
                for item in items[first::workers]:
                    function(item)
        except BaseException as caught:
            error = caught
        channel.put(error)

    started = [fork.Process(target=work, args=(first,)) for first in range(1, workers)]
    for process in started:
        process.start()
    try:
        with _busy():
            for item in items[::workers]:
                function(item)
        for process in started:
            process.join()
            if process.exitcode != 0:
                raise RuntimeError(f"a process of physident was ended from outside (code {process.exitcode})")
            error = channel.get()
            if error is not None:
                raise error
    finally:
        for process in started:
            process.terminate()
            process.join()
