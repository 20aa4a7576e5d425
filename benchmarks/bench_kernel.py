"""The batch kernel beside NumPy's addition and OMPL.

It also takes 10^8 rows in chunks.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from time import perf_counter

import numpy as np

from benchmarks.harness import Measurement, absent, side_by_side, sized
from benchmarks.peers import CALLS, NAMES, NO_OMPL, ompl_distances, random_frame
from dubins_study.study.closed_form.kernel import Rows, shortest_rows

N = sized(1_000_000, 1_000)
CHUNKS = sized(100, 4)
_STATM = Path("/proc/self/statm")


def measure() -> Iterable[Measurement]:
    data = [
        [frame[name].to_numpy() for name in NAMES]
        for frame in (random_frame(N, seed) for seed in range(4))
    ]
    out = Rows.empty(2, N)
    total = np.empty(N)
    a, b = data[0][:2]
    functions = {
        "kernel": lambda: shortest_rows(*data[0], out=out),
        "add": lambda: np.add(a, b, out=total),
    }
    distances = ompl_distances()
    times = side_by_side(functions, repeats=25)
    ours = times["kernel"]
    add = times["add"]
    yield Measurement(
        "kernel, 10^6 rows, against np.add of two arrays",
        ours=ours.least / N * 1e9,
        peer=add.least / N * 1e9,
        unit="ns/row",
        ratio=ours.least / add.least,
        target=8.0,
        note=f"ours / peer; of medians {ours.median / add.median:.1f}",
    )
    if distances is None:
        yield absent("kernel, 10^6 rows, against OMPL distance()", NO_OMPL)
    else:
        times = side_by_side({"kernel": functions["kernel"], "ompl": distances}, repeats=15)
        ours, peer = times["kernel"], times["ompl"]
        yield Measurement(
            "kernel, 10^6 rows, against OMPL distance()",
            ours=ours.least / N * 1e9,
            peer=peer.least / CALLS * 1e9,
            unit="ns/row",
            ratio=peer.least / CALLS / (ours.least / N),
            target=60.0,
            at_most=False,
            note=f"peer / ours; of medians {peer.median / CALLS / (ours.median / N):.0f}",
        )
    yield from _chunks(data, out)


def _chunks(data: list[list[np.ndarray]], out: Rows) -> Iterable[Measurement]:
    """10^8 rows beside one million alone.

    They are taken a million at a time from four different frames.
    """
    alone = side_by_side({"kernel": lambda: shortest_rows(*data[0], out=out)}, 15)["kernel"]
    before = _resident()
    began = perf_counter()
    for chunk in range(CHUNKS):
        shortest_rows(*data[chunk % len(data)], out=out)
    mean = (perf_counter() - began) / CHUNKS
    yield Measurement(
        "kernel, 10^8 rows in chunks of 10^6, against 10^6",
        ours=mean / N * 1e9,
        peer=alone.median / N * 1e9,
        unit="ns/row",
        ratio=mean / alone.median,
        target=1.3,
        note="mean over all chunks / median alone",
    )
    if before is None:
        yield absent("memory after 10^8 rows, against before", "/proc is not here to ask")
        return
    after = _resident() or before
    yield Measurement(
        "memory after 10^8 rows, against before",
        ours=after,
        peer=before,
        unit="MB",
        ratio=after / before,
        target=1.02,
    )


def _resident() -> float | None:
    """Resident memory in MB; None if unknown."""
    if not _STATM.exists():
        return None
    return int(_STATM.read_text().split()[1]) * 4096 / 1e6
