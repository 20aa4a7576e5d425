"""10^6 legs with a final heading in one thread.

They are compared with OMPL and `dubins`, and judged.

`pip download --no-deps --no-binary :all: dubins==1.0.1 -d FOLDER` brings the sources of the wheel
`dubins`, and `--peers FOLDER` builds its C code in a temporary folder.
"""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tarfile
from collections.abc import Callable, Iterable
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

import numba
import numpy as np
import pandas as pd

from benchmarks import harness
from benchmarks.harness import Measurement, absent, side_by_side, sized
from benchmarks.peers import CALLS, NO_OMPL, PAIRS, ROUNDS
from dubins_study.asking.frame import solve_frame
from dubins_study.study.arrays import FloatArray
from dubins_study.study.check.enclosure import enclose_pose
from dubins_study.study.closed_form.kernel import Rows
from dubins_study.study.closed_form.pose_kernel import PoseArrays, pose_rows
from dubins_study.study.scenario import Pose

N = sized(1_000_000, 1_000)
ALIKE = 1e-12  # of two lengths, relative to them or in radii
NO_SOURCES = "no sources: --peers FOLDER with dubins-1.0.1.tar.gz, and a C compiler"
Lengths = Callable[[PoseArrays, FloatArray], None]  # fills the second from the first


def measure() -> Iterable[Measurement]:
    threads = numba.config.NUMBA_NUM_THREADS
    numba.config.NUMBA_NUM_THREADS = 1
    try:
        yield from _measure()
    finally:
        numba.config.NUMBA_NUM_THREADS = threads


def _measure() -> Iterable[Measurement]:
    legs = random_legs(N)
    out = Rows.empty(3, N)
    theirs = np.empty(N)
    few = PoseArrays(*(column[:PAIRS] for column in legs))
    frame = pd.DataFrame(legs._asdict())

    def kernel() -> None:
        pose_rows(*legs, out=out)

    ompl = _ompl_lengths(few)
    dubins = _dubins_lengths()
    functions: dict[str, Callable[[], object]] = {"kernel": kernel}
    functions["frame"] = lambda: solve_frame(frame)
    calls = {"OMPL distance()": CALLS, "the C code of dubins": N}
    if ompl is not None:
        functions["OMPL distance()"] = ompl
    if dubins is not None:
        functions["the C code of dubins"] = lambda: dubins(legs, theirs)
    times = side_by_side(functions)
    ours = times["kernel"]
    for (name, n), reason in zip(calls.items(), (NO_OMPL, NO_SOURCES), strict=True):
        what = f"legs, 10^6 rows in one thread, against {name}"
        if name not in times:
            yield absent(what, reason)
            continue
        peer = times[name]
        yield Measurement(
            what,
            ours=ours.least / N * 1e9,
            peer=peer.least / n * 1e9,
            unit="ns/row",
            ratio=peer.least / n / (ours.least / N),
            target=20.0,
            at_most=False,
            note=f"peer / ours; of medians {peer.median / n / (ours.median / N):.0f}",
        )
    whole = times["frame"]
    yield Measurement(
        "legs, 10^6 rows of solve_frame",
        ours=whole.least / N * 1e9,
        peer=ours.least / N * 1e9,
        unit="ns/row",
        ratio=whole.least / ours.least,
        note=f"checked, solved, judged; of medians {whole.median / ours.median:.1f}",
    )
    legs = random_legs(N, seed=1, sizes=(0.03, 30.0))
    kernel()
    if ompl is not None:
        _ompl_lengths(legs, theirs)
        yield _agreement("OMPL", legs, out.length, theirs)
    if dubins is not None:
        dubins(legs, theirs)
        yield _agreement("dubins", legs, out.length, theirs)


def random_legs(n: int, seed: int = 0, sizes: tuple[float, float] = (5.0, 5.0)) -> PoseArrays:
    """n random legs with all headings.

    Their squares have half widths from the one size to the other.

    In those of 5 R half of the points are less than 5 R apart.
    """
    rng = np.random.default_rng(seed)
    size = np.exp(rng.uniform(*np.log(sizes), n))
    x, y, tx, ty = size * rng.uniform(-1, 1, (4, n))
    heading, final = rng.uniform(-np.pi, np.pi, (2, n))
    return PoseArrays(x, y, heading, tx, ty, np.ones(n), final)


def _poses(legs: PoseArrays, i: int) -> tuple[Pose, Pose, float]:
    x, y, heading, tx, ty, radius, final = (float(column[i]) for column in legs)
    return Pose(x, y, heading), Pose(tx, ty, final), radius


def _agreement(name: str, legs: PoseArrays, ours: FloatArray, theirs: FloatArray) -> Measurement:
    """Number of lengths that differ.

    Also: of how many of them a proven interval does not side with us alone.
    """
    other = np.flatnonzero(~(np.abs(theirs - ours) <= ALIKE * np.maximum(ours, 1.0)))
    worst = 0.0
    unexplained = 0
    for i in other.tolist():
        proven = enclose_pose(*_poses(legs, i))
        unexplained += not proven.holds(ours[i], 0.0) or proven.holds(theirs[i], 0.0)
        worst = max(worst, abs(theirs[i] - ours[i]))
    return Measurement(
        f"legs, 10^6 lengths, more than {ALIKE:g} from {name}'s",
        ours=unexplained,
        peer=other.size,
        unit="rows",
        ratio=unexplained,
        target=0.0,
        note=f"ours: not proven to be {name}'s error; peer: all, up to {worst:.1e} R",
    )


def _ompl_lengths(legs: PoseArrays, out: FloatArray | None = None) -> Callable[[], object] | None:
    """Time of OMPL's lengths called from Python.

    `DubinsStateSpace.distance()` is called `CALLS` times, on states made before.

    With `out` each is called once instead, and its length is kept there.
    """
    if find_spec("ompl") is None:
        return None
    from ompl import base

    space = base.DubinsStateSpace(1.0)

    def state(x: float, y: float, heading: float) -> object:
        pose = space.allocState()
        pose.setX(x)
        pose.setY(y)
        pose.setYaw(heading)
        return pose

    rows = zip(*(column.tolist() for column in legs), strict=True)
    states = ((state(x, y, a), state(tx, ty, b)) for x, y, a, tx, ty, _, b in rows)
    distance = space.distance
    if out is not None:
        for i, (start, end) in enumerate(states):
            out[i] = distance(start, end)
        return None
    pairs = list(states)

    def every() -> None:
        for _ in range(ROUNDS):
            for start, end in pairs:
                distance(start, end)

    return every


def _dubins_lengths() -> Lengths | None:
    """A compiled loop over the C code of `dubins`.

    It calls `dubins_shortest_path` and `dubins_path_length` for every row.
    """
    archives = sorted((harness.peer_sources or Path("nowhere")).glob("dubins-*.tar.gz"))
    compiler = shutil.which("cc")
    if not archives or compiler is None:
        return None
    with TemporaryDirectory() as folder:
        with tarfile.open(archives[-1]) as archive:
            archive.extractall(folder, filter="data")
        [source] = Path(folder).glob("*/dubins/src/dubins.c")
        library = Path(folder) / "dubins.so"
        flags = ["-O2", "-shared", "-fPIC", "-I", source.parents[1] / "include", "-o", library]
        subprocess.run([compiler, *flags, source, "-lm"], check=True)
        loaded = ctypes.CDLL(str(library))
    shortest = loaded.dubins_shortest_path
    length = loaded.dubins_path_length
    pointer = ctypes.c_void_p
    shortest.argtypes = (pointer, pointer, pointer, ctypes.c_double)
    shortest.restype = ctypes.c_int
    length.argtypes = (pointer,)
    length.restype = ctypes.c_double

    @numba.njit  # type: ignore[untyped-decorator]
    def every(legs: PoseArrays, out: FloatArray) -> None:
        x, y, heading, tx, ty, radius, final = legs
        path, start, end = np.zeros(16), np.empty(3), np.empty(3)  # a path has 64 bytes
        for i in range(x.size):
            start[0], start[1], start[2] = x[i], y[i], heading[i]
            end[0], end[1], end[2] = tx[i], ty[i], final[i]
            shortest(path.ctypes.data, start.ctypes.data, end.ctypes.data, radius[i])
            out[i] = length(path.ctypes.data)

    return every
