"""Legs with a final heading, 10^6 in one thread: beside OMPL, the wheel `dubins`, and certified."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from importlib.util import find_spec

import numba
import numpy as np

from benchmarks.harness import Measurement, absent, side_by_side, sized
from benchmarks.peers import CALLS, NO_OMPL, PAIRS, ROUNDS
from dubins_study.study.check.pose_enclosure import enclose_pose
from dubins_study.study.check.pose_enclosure_kernel import bound_pose_rows
from dubins_study.study.closed_form.pose_kernel import PoseArrays, PoseRows, pose_rows
from dubins_study.study.scenario import Pose

N = sized(1_000_000, 1_000)
Poses = tuple[float, float, float]


def measure() -> Iterable[Measurement]:
    threads = numba.get_num_threads()
    numba.set_num_threads(1)
    try:
        yield from _measure()
    finally:
        numba.set_num_threads(threads)


def _measure() -> Iterable[Measurement]:
    legs, out = random_legs(N), PoseRows.empty(N)
    pairs = [
        ((x, y, heading), (tx, ty, final))
        for x, y, heading, tx, ty, _, final in zip(*(a[:PAIRS].tolist() for a in legs), strict=True)
    ]

    def kernel() -> None:
        pose_rows(*legs, out=out)

    def certified() -> None:
        kernel()
        bounds = bound_pose_rows(legs)
        for i in np.flatnonzero(bounds.left).tolist():
            x, y, heading, tx, ty, radius, final = (float(column[i]) for column in legs)
            # what the cache holds would cost nothing
            enclose_pose.__wrapped__(Pose(x, y, heading), Pose(tx, ty, final), radius)

    peers = {
        "OMPL distance()": (_ompl_distances(pairs), NO_OMPL),
        "dubins path_length()": (_wheel_lengths(pairs), "dubins is not installed"),
    }
    functions = {"kernel": kernel, "certified": certified}
    functions |= {name: run for name, (run, _) in peers.items() if run is not None}
    times = side_by_side(functions)
    ours = times["kernel"]
    for name, (_, reason) in peers.items():
        what = f"legs, 10^6 rows in one thread, against {name}"
        if name not in times:
            yield absent(what, reason)
            continue
        peer = times[name]
        yield Measurement(
            what,
            ours=ours.least / N * 1e9,
            peer=peer.least / CALLS * 1e9,
            unit="ns/row",
            ratio=peer.least / CALLS / (ours.least / N),
            target=20.0,
            at_most=False,
            note=f"peer / ours; of medians {peer.median / CALLS / (ours.median / N):.0f}",
        )
    proven = times["certified"]
    yield Measurement(
        "legs, 10^6 rows with proven bounds, against without",
        ours=proven.least / N * 1e9,
        peer=ours.least / N * 1e9,
        unit="ns/row",
        ratio=proven.least / ours.least,
        target=12.0,
        note=f"with balls for the rows left; of medians {proven.median / ours.median:.1f}",
    )


def random_legs(n: int, seed: int = 0) -> PoseArrays:
    """n legs in a square of ten radii, all headings: half of the points less than 5 R apart."""
    rng = np.random.default_rng(seed)
    x, y, tx, ty = rng.uniform(-5, 5, (4, n))
    heading, final = rng.uniform(-np.pi, np.pi, (2, n))
    return PoseArrays(x, y, heading, tx, ty, np.ones(n), final)


def _ompl_distances(pairs: list[tuple[Poses, Poses]]) -> Callable[[], object] | None:
    """`DubinsStateSpace.distance()` called from Python `CALLS` times, on states made before."""
    if find_spec("ompl") is None:
        return None
    from ompl import base

    space = base.DubinsStateSpace(1.0)

    def state(pose: Poses) -> object:
        made = space.allocState()
        made.setX(pose[0])
        made.setY(pose[1])
        made.setYaw(pose[2])
        return made

    states = [(state(start), state(end)) for start, end in pairs]
    distance = space.distance

    def every() -> None:
        for _ in range(ROUNDS):
            for start, end in states:
                distance(start, end)

    return every


def _wheel_lengths(pairs: list[tuple[Poses, Poses]]) -> Callable[[], object] | None:
    """`dubins.shortest_path(...).path_length()`, `CALLS` times."""
    if find_spec("dubins") is None:
        return None
    from dubins import shortest_path

    def every() -> None:
        for _ in range(ROUNDS):
            for start, end in pairs:
                shortest_path(start, end, 1.0).path_length()

    return every
