"""`solve_frame` with the closed form, beside OMPL.

Validation and judging are included.
"""

from __future__ import annotations

from collections.abc import Iterable

from benchmarks.harness import Measurement, absent, side_by_side, sized
from benchmarks.peers import CALLS, NO_OMPL, ompl_distances, random_frame
from dubins_study.asking.frame import solve_frame

N = sized(1_000_000, 1_000)


def measure() -> Iterable[Measurement]:
    what = "solve_frame, 10^6 rows, against OMPL distance()"
    frame = random_frame(N)
    distances = ompl_distances()
    if distances is None:
        yield absent(what, NO_OMPL)
        return
    times = side_by_side({"frame": lambda: solve_frame(frame), "ompl": distances}, repeats=15)
    ours, peer = times["frame"], times["ompl"]
    yield Measurement(
        what,
        ours=ours.least / N * 1e9,
        peer=peer.least / CALLS * 1e9,
        unit="ns/row",
        ratio=peer.least / CALLS / (ours.least / N),
        target=3.0,
        at_most=False,
        note=f"peer / ours; of medians {peer.median / CALLS / (ours.median / N):.1f}",
    )
