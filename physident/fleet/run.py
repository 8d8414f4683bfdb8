"""A fleet's recordings, worked on by a Dask cluster: only those that are new, each written as soon as it is done."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.fleet.dataset import FleetFolder, file_hash, robot_hash, write_rows
from physident.fleet.naming import arm_and_day, pattern_of
from physident.fleet.work import Reading, Task, make_baseline, rows_of_file
from physident.processes import processors
from physident.recordings.load import find_recordings
from physident.robots.load import load_robot
from physident.robots.robot import Robot

BASELINE = 4  # recordings of an arm that its baseline is identified from
RETRIES = 5  # of a file whose worker was lost


@dataclass(frozen=True)
class FleetResult:
    """What a run has done: files that were new, those that were known already, and those that cannot be used."""

    new: int
    known: int
    broken: int
    arms: int

    def __repr__(self) -> str:
        text = f"{self.arms} arms: {self.new} new recordings, {self.known} known already"
        return text + (f"; {self.broken} cannot be used (column error)" if self.broken else "")


def run_fleet(
    robot: Robot | str | Path,
    files: Sequence[str | Path],
    by: str,
    out: str | Path,
    reading: Reading | None = None,
    baseline: int = BASELINE,
    scheduler: str | None = None,
    workers: int | None = None,
    done: Callable[[int, int], object] | None = None,
) -> FleetResult:
    """Measure what changed on each arm since its baseline, in every recording that ``out`` does not hold yet.

    ``by`` names arm and day of each file, see ``pattern_of``. The baseline of an arm is identified from its first ``baseline``
    recordings. A file that cannot be used becomes a row with its reason. ``scheduler`` is the address of a Dask cluster; without one,
    ``workers`` processes of this machine are used. ``done`` is told how many files of how many are finished. Raises InputError for
    paths that do not fit ``by``, and for a folder of another fleet.
    """
    robot = robot if isinstance(robot, Robot) else load_robot(robot)
    reading, pattern = reading or Reading(), pattern_of(by)
    if baseline < 1:
        raise InputError(f"baseline is {baseline}, expected a number of recordings, 1 or more")
    named = [(file, *arm_and_day(file, pattern)) for file in find_recordings(files)]
    folder = FleetFolder(Path(out))
    folder.prepare({"robot": robot_hash(robot), "baseline": baseline, "reading": _plain(reading)})
    named.sort(key=lambda one: (one[1], one[2], one[0]))
    every = [
        Task(file=file, digest=file_hash(file), arm=arm, day=day, baseline=str(folder.baseline(arm).resolve()))
        for file, arm, day in named
    ]
    tasks = {task.digest: task for task in every if not folder.part(task.digest).exists()}
    arms = {arm: [file for file, other, _ in named if other == arm] for arm in {task.arm for task in tasks.values()}}
    missing = {arm: own for arm, own in sorted(arms.items()) if not folder.baseline(arm).exists()}
    broken = finished = 0
    if tasks:
        with cluster(scheduler, workers) as client:
            baselines = client.map(
                lambda own: make_baseline(robot, own, baseline, reading),
                list(missing.values()),
                pure=False,
                retries=RETRIES,
            )
            for arm, found in zip(missing, client.gather(baselines), strict=True):
                if isinstance(found, Estimate):
                    found.save(folder.baseline(arm))
            for rows in _each(client, list(tasks.values()), robot, reading):
                write_rows(folder.part(rows[0]["hash"]), rows)
                finished, broken = finished + 1, broken + ("error" in rows[0])
                if done is not None:
                    done(finished, len(tasks))
    return FleetResult(new=finished, known=len(every) - len(tasks), broken=broken, arms=len({t.arm for t in every}))


def _each(client: Any, tasks: list[Task], robot: Robot, reading: Reading) -> Iterator[list[dict[str, Any]]]:
    """The rows of each file, in the order in which workers finish."""
    from distributed import as_completed

    shared = client.scatter((robot, reading), broadcast=True)
    futures = client.map(
        lambda task, given: rows_of_file(task, *given), tasks, given=shared, pure=False, retries=RETRIES
    )
    by_key = {future.key: task for future, task in zip(futures, tasks, strict=True)}
    for future in as_completed(futures):
        if future.status == "finished":
            yield future.result()
            continue
        task = by_key[future.key]
        reason = (
            f"its worker was lost {RETRIES} times ({type(future.exception()).__name__}); expected a smaller recording"
        )
        yield [{"arm": task.arm, "day": task.day, "file": task.file, "hash": task.digest, "error": reason}]
        future.release()


@contextmanager
def cluster(scheduler: str | None, workers: int | None) -> Iterator[Any]:
    """A client of a Dask cluster: the one at an address, or one of this machine; raises InputError without Dask."""
    try:
        from dask import config
        from distributed import Client, LocalCluster
    except ImportError:
        raise InputError(
            "a fleet needs the packages dask and distributed; install them: pip install 'physident[fleet]'"
        ) from None
    settings = {"distributed.scheduler.allowed-failures": RETRIES, "distributed.admin.log-format": "%(message)s"}
    with config.set(settings):
        if scheduler is not None:
            try:
                client = Client(scheduler, timeout=10)
            except (OSError, ValueError, TimeoutError) as error:
                raise InputError(
                    f"scheduler {scheduler!r} does not answer ({type(error).__name__}); expected an address such as tcp://host:8786"
                ) from None
            with client:
                yield client
            return
        count = processors() if workers is None else workers
        with (
            LocalCluster(
                n_workers=count,
                threads_per_worker=1,
                memory_limit=0,
                silence_logs=50,
                dashboard_address=":0",  # any port that is free
            ) as local,
            Client(local) as client,
        ):
            yield client


def _plain(reading: Reading) -> dict[str, Any]:
    return {key: list(value) if isinstance(value, tuple) else value for key, value in asdict(reading).items()}
