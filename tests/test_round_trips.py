"""The same recording in every format gives the same estimate, also with its joints in another order."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from scipy.io import savemat

import physident as pid
from tests.bags import UR_JOINTS, write_bag, write_lerobot
from tests.loads import arm, record

SHUFFLED = (2, 5, 0, 1, 4, 3)


@pytest.fixture(scope="module")
def run(ur5: pid.Robot) -> pid.Recording:
    """Twenty seconds of a simulated UR5, at times of whole nanoseconds."""
    one = record(arm(ur5), seed=3)
    return pid.Recording.from_arrays(np.round(one.time * 1e9) / 1e9, one.q, one.effort, one.dq)


@pytest.fixture(scope="module")
def expected(ur5: pid.Robot, run: pid.Recording) -> np.ndarray:
    return pid.identify(ur5, run).theta


def names(effort: str = "tau") -> list[str]:
    return ["time", *(f"{kind}_{j}" for kind in ("q", "dq", effort) for j in range(1, 7))]


def values(run: pid.Recording) -> np.ndarray:
    assert run.dq is not None
    return np.column_stack([run.time, run.q, run.dq, run.effort])


def text(run: pid.Recording, header: str, separator: str) -> str:
    """Every number with all its digits."""
    return "\n".join([header, *(separator.join(map(repr, row)) for row in values(run).tolist())]) + "\n"


def csv(folder: Path, run: pid.Recording) -> Path:
    (folder / "r.csv").write_text(text(run, ",".join(names()), ","))
    return folder / "r.csv"


def semicolons(folder: Path, run: pid.Recording) -> Path:
    (folder / "r.csv").write_text(text(run, ";".join(names()), ";").replace(".", ","))
    return folder / "r.csv"


def tabs(folder: Path, run: pid.Recording) -> Path:
    (folder / "r.txt").write_text(text(run, "\t".join(names()), "\t"))
    return folder / "r.txt"


def commented(folder: Path, run: pid.Recording) -> Path:
    (folder / "r.txt").write_text("# made by a logger\n" + text(run, "# " + " ".join(names()), "  "))
    return folder / "r.txt"


def npz(folder: Path, run: pid.Recording) -> Path:
    assert run.dq is not None
    np.savez(folder / "r.npz", time=run.time, q=run.q, dq=run.dq, tau=run.effort)
    return folder / "r.npz"


def parquet(folder: Path, run: pid.Recording) -> Path:
    pq.write_table(pa.table(dict(zip(names(), values(run).T, strict=True))), folder / "r.parquet")
    return folder / "r.parquet"


def parquet_lists(folder: Path, run: pid.Recording) -> Path:
    assert run.dq is not None
    lists = {"q": run.q, "dq": run.dq, "tau": run.effort}
    columns = {"time": pa.array(run.time)} | {name: pa.array(array.tolist()) for name, array in lists.items()}
    pq.write_table(pa.table(columns), folder / "r.parquet")
    return folder / "r.parquet"


def mcap(folder: Path, run: pid.Recording) -> Path:
    return write_bag(folder / "bag", run)


def mcap_file(folder: Path, run: pid.Recording) -> Path:
    return next(write_bag(folder / "bag", run).glob("*.mcap"))


def db3(folder: Path, run: pid.Recording) -> Path:
    return write_bag(folder / "bag", run, storage="sqlite3")


def db3_without_metadata(folder: Path, run: pid.Recording) -> Path:
    bag = write_bag(folder / "bag", run, storage="sqlite3")
    (bag / "metadata.yaml").unlink()
    return bag


def shuffled_mcap(folder: Path, run: pid.Recording) -> Path:
    return write_bag(folder / "bag", run, order=SHUFFLED)


def prefixed_db3(folder: Path, run: pid.Recording) -> Path:
    prefixed = [f"left_{name}" for name in UR_JOINTS]
    return write_bag(folder / "bag", run, names=prefixed, storage="sqlite3", order=SHUFFLED)


def mat(folder: Path, run: pid.Recording) -> Path:
    savemat(folder / "r.mat", {"time": run.time, "q": run.q, "dq": run.dq, "tau": run.effort, "note": "first"})
    return folder / "r.mat"


def mat_struct(folder: Path, run: pid.Recording) -> Path:
    fields = {"time": run.time, "q": run.q, "dq": run.dq, "tau": run.effort}
    savemat(folder / "r.mat", {"run": fields}, do_compression=True, oned_as="column")
    return folder / "r.mat"


def lerobot(folder: Path, run: pid.Recording) -> Path:
    return write_lerobot(folder / "set", [run])


def session(folder: Path, run: pid.Recording) -> Path:
    pid.view(recordings=run, robot=pid.load_robot("ur5"), to=folder / "r.rrd")
    return folder / "r.rrd"


FILES: list[Callable[[Path, pid.Recording], Path]] = [
    csv, semicolons, tabs, commented, npz, parquet, parquet_lists, mcap, mcap_file, db3, db3_without_metadata,
    shuffled_mcap, prefixed_db3, mat, mat_struct, lerobot, session,
]  # fmt: skip


def agrees(found: np.ndarray, expected: np.ndarray) -> bool:
    return bool(np.abs(found - expected).max() <= 1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("write", FILES, ids=lambda write: write.__name__)
@pytest.mark.filterwarnings("ignore:.*joints are matched by the ends of their names")
def test_every_format_gives_the_same_estimate(
    write: Callable[[Path, pid.Recording], Path],
    tmp_path: Path,
    ur5: pid.Robot,
    run: pid.Recording,
    expected: np.ndarray,
) -> None:
    path = write(tmp_path, run)
    assert agrees(pid.identify(ur5, str(path)).theta, expected)
    (loaded,) = pid.load_recordings(path, joints=ur5.joint_names if "bag" in path.parts[-2:] else None)
    for channel in ("time", "q", "dq", "effort"):
        np.testing.assert_array_equal(getattr(loaded, channel), getattr(run, channel))


def test_frames_and_arrays_give_the_same_estimate(ur5: pid.Robot, run: pid.Recording, expected: np.ndarray) -> None:
    frame = run.to_pandas()
    assert list(frame.columns) == names()
    for one in (
        pid.Recording.from_frame(frame),
        pid.Recording.from_frame(pl.from_pandas(frame)),
        pid.Recording.from_frame(frame.iloc[:, ::-1]),
        pid.Recording.from_frame(frame.assign(time=pd.to_datetime(frame["time"], unit="s"))),
        pid.Recording.from_arrays(run.time.tolist(), run.q.tolist(), run.effort, run.dq),
    ):
        assert agrees(pid.identify(ur5, one).theta, expected)


def test_joints_of_arrays_go_by_their_names(ur5: pid.Robot, run: pid.Recording, expected: np.ndarray) -> None:
    assert run.dq is not None
    order = list(SHUFFLED)
    mixed = pid.Recording.from_arrays(
        run.time, run.q[:, order], run.effort[:, order], run.dq[:, order], joint_names=[UR_JOINTS[j] for j in order]
    )
    estimate = pid.identify(ur5, [mixed])
    assert agrees(estimate.theta, expected)
    # the same recording in another order of joints is still one that the model was fitted to
    with pytest.raises(pid.InputError, match="training recording"):
        pid.validate(estimate, run)


def test_rows_without_a_clock_take_a_rate(tmp_path: Path, ur5: pid.Robot, run: pid.Recording) -> None:
    assert run.dq is not None
    np.savetxt(tmp_path / "r.txt", np.delete(values(run), 100, axis=0)[:, 1:], header=" ".join(names()[1:]))
    with pytest.raises(pid.InputError, match=r"no time column.*--rate"):
        pid.load_recording(tmp_path / "r.txt")
    loaded = pid.load_recording(tmp_path / "r.txt", rate=125.0)
    np.testing.assert_allclose(np.diff(loaded.time), 1 / 125, rtol=1e-9)
    arrays = pid.Recording.from_arrays(None, run.q, run.effort, rate=125.0)
    np.testing.assert_allclose(arrays.time, np.arange(len(run.time)) / 125)


def test_a_bad_row_without_a_clock_leaves_a_gap(tmp_path: Path, run: pid.Recording) -> None:
    lines = text(run, ",".join(names()), ",").splitlines()
    rows = [line.partition(",")[2] for line in lines]
    rows[50] = "1,2"
    (tmp_path / "r.csv").write_text("\n".join(rows) + "\n")
    loaded = pid.load_recording(tmp_path / "r.csv", rate=125.0)
    assert [bad.row for bad in loaded.rejected] == [51]
    assert np.diff(loaded.time).max() == pytest.approx(2 / 125)
