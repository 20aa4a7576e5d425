"""The search for tours: time and worth.

Measured are how long a proof takes, what shorter ways cost, and what each part is worth.

A tour starts at (0, 0) with a given heading and ends at a target with a free one; its points and
target are drawn in a square from a seed. Seconds are of CPU time in one thread.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from itertools import pairwise
from statistics import median
from time import process_time
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np

from benchmarks.harness import Measurement, absent, sized
from benchmarks.tour_genetic import NO_DEAP, evolved
from benchmarks.tour_routing import NO_ORTOOLS, routed
from dubins_study.study.arrays import FloatArray
from dubins_study.study.closed_form.pose import shortest_to_pose
from dubins_study.study.kinds.shortest import BOXES_A_SECOND
from dubins_study.study.route.search import search
from dubins_study.study.scenario import Pose
from dubins_study.study.tour import orders
from dubins_study.study.tour import search as tour_search
from dubins_study.study.tour.chains import leave_out
from dubins_study.study.tour.search import search_tour
from dubins_study.study.tour.short_orders import better_order
from dubins_study.study.tour.stops import Stops

SEED = 34
SETS = sized(10, 1)
OPEN_GAP = 0.02  # of the interval that is wanted of more points than are proved


class Size(NamedTuple):
    """Tours of one size, and their targets."""

    points: int
    side: float  # of the square, in radii times the root of the number of points
    tolerance: float  # of the interval, relative
    seconds: float  # median
    closed: int  # of ten that close
    ends_at_start: bool = False


SIZES = [
    Size(10, 8.0, 1e-9, 0.3, 10),
    Size(20, 8.0, 1e-9, 5.0, 10),
    Size(30, 8.0, 1e-9, 40.0, 8),
    Size(50, 8.0, 1e-9, 60.0, 0),
    Size(10, 3.0, 1e-6, 4.0, 10),
    Size(12, 3.0, 1e-6, 8.0, 10),
    Size(16, 3.0, 1e-6, 60.0, 7),
    Size(8, 1.5, 1e-6, 60.0, 7),
    Size(20, 8.0, 1e-6, 30.0, 10, ends_at_start=True),
]
BESIDE = [SIZES[0], SIZES[4], SIZES[1]]  # where shorter ways and parts are compared
_PATIENCE = 4.0  # times the work of the seconds that are wanted, where a proof is: it ends then


class Timed(NamedTuple):
    """What a call returned, and its CPU time (s)."""

    result: Any
    seconds: float


def timed(call: Callable[..., Any], *values: Any, **options: Any) -> Timed:
    """Call a function."""
    began = process_time()
    result = call(*values, **options)
    return Timed(result, process_time() - began)


def random_tour(size: Size, seed: int) -> Stops:
    """One tour of a size."""
    rng = np.random.default_rng([SEED, size.points, round(10 * size.side), seed])
    square = size.side * math.sqrt(size.points)
    points = rng.uniform(0.0, square, (size.points, 2))
    free = [None] * size.points
    if size.ends_at_start:
        return Stops(points, free, None, (0.0, 0.0), None, closed=True)
    target = tuple(rng.uniform(0.0, square, 2).tolist())
    return Stops(points, free, float(rng.uniform(-3.0, 3.0)), target, None)


def proved(size: Size, stops: Stops) -> Timed:
    """Run the search with a budget of work.

    The budget does not depend on what else the machine does.

    Where an interval is wanted and no proof, it ends when the seconds are over.
    """
    boxes = sized(round(_PATIENCE * size.seconds * BOXES_A_SECOND), 10_000)
    limit = math.inf if size.closed else size.seconds
    return timed(search_tour, stops, limit=limit, boxes=boxes, tolerance=size.tolerance)


def measure() -> Iterable[Measurement]:
    search_tour(random_tour(Size(3, 8.0, 1e-6, 1.0, 1), 0), limit=10.0)  # compiles
    known: dict[Size, list[Timed]] = {}
    for size in SIZES:
        known[size] = [proved(size, random_tour(size, seed)) for seed in range(SETS)]
        yield proof_row(size, known[size])
    for size in BESIDE:
        yield from shorter_ways(size, known[size])
    for size in BESIDE:
        yield from without_parts(size, known[size])


def named(size: Size) -> str:
    """What a row is of."""
    closed = ", closed, its heading free" if size.ends_at_start else ""
    return f"{size.points} points, {size.side:g}R sqrt(n){closed}"


def proof_row(size: Size, found: Sequence[Timed]) -> Measurement:
    """Times of the proofs.

    For the largest tours the row has the width of the interval.
    """
    gaps = [(each.result.high - each.result.low) / each.result.high for each in found]
    closed = sum(each.result.closed for each in found)
    seconds = median(each.seconds for each in found)
    wanted = size.closed * len(found) / 10
    share = math.inf if closed < wanted else seconds / size.seconds
    if size.closed == 0:
        share = median(gaps) / OPEN_GAP
    return Measurement(
        f"proof of {named(size)}",
        ours=seconds,
        peer=size.seconds,
        unit="s",
        ratio=share,
        target=1.0,
        note=f"median CPU; {closed} of {len(found)} closed to {size.tolerance:g}, wanted "
        f"{wanted:g}; gap {median(gaps):.1e}, at most {max(gaps):.1e}; "
        f"{median(each.result.orders for each in found):g} orders searched",
    )


def shorter_ways(size: Size, found: Sequence[Timed]) -> Iterator[Measurement]:
    """Loss and time of ways without a proof.

    All ways take the same points.
    """
    for way, (length_of, missing) in WAYS.items():
        what = f"{way}: {named(size)}"
        timings = [timed(length_of, random_tour(size, seed)) for seed in range(len(found))]
        if any(math.isnan(each.result) for each in timings):
            yield absent(what, missing)
            continue
        above = [
            each.result / proof.result.high - 1.0
            for each, proof in zip(timings, found, strict=True)
        ]
        yield Measurement(
            what,
            ours=median(proof.seconds for proof in found),
            peer=median(each.seconds for each in timings),
            unit="s",
            note=f"longer by {median(above):.1%} at the median, {max(above):.1%} at most",
        )


def euclidean_order(stops: Stops) -> list[int]:
    """The shortest polygon of a local search.

    Parts of it are turned round and points are moved.
    """
    n = len(stops.points)
    apart = np.hypot(*(stops.points[:, None] - stops.points[None]).transpose(2, 0, 1))
    apart[np.diag_indices(n)] = math.inf
    starts = np.hypot(*stops.points.T)
    ends = np.hypot(*(stops.points - np.array(stops.target)).T)
    rng = np.random.default_rng(0)
    best = [0]
    shortest = math.inf
    for _ in range(10):
        order = rng.permutation(n)
        before = math.inf
        while (length := better_order(order, np.arange(n + 1), apart, starts, ends)) < before:
            before = length
        if length < shortest:
            best = order.tolist()
            shortest = length
    return best


def euclidean_headings(stops: Stops) -> float:
    """Length of the best headings for the Euclidean order."""
    points, headings = stops.route(euclidean_order(stops))
    route = search(points, headings[0], headings[-1], limit=20.0, tolerance=1e-9)
    return route.length


def alternating(stops: Stops) -> float:
    """Length of a tour by the alternating algorithm.

    It drives straight along each second edge of the Euclidean order, and a Dubins path between.

    Savla, Frazzoli and Bullo 2005, On the point-to-point and traveling salesperson problems for
    Dubins' vehicle.
    """
    points, _ = stops.route(euclidean_order(stops))
    edges = np.diff(points, axis=0)
    along = np.arctan2(edges[:, 1], edges[:, 0])
    headings = np.append(stops.first, along)  # the last edge's, at the target
    for i in range(1, len(along), 2):
        headings[i] = headings[i + 1] = along[i]
    return length_of_poses(points, headings)


def length_of_poses(points: FloatArray, headings: FloatArray) -> float:
    """The length of the legs between poses."""
    poses = [Pose(x, y, angle) for (x, y), angle in zip(points, headings, strict=True)]
    legs = [shortest_to_pose(*both, 1.0) for both in pairwise(poses)]
    return math.fsum(leg.total for leg in legs if leg is not None)


# shorter ways, each with the reason where it cannot be tried
WAYS: dict[str, tuple[Callable[[Stops], float], str]] = {
    "Euclidean order, best headings": (euclidean_headings, ""),
    "alternating straight legs": (alternating, ""),
    "OR-tools' routing, 8 headings a point": (routed, NO_ORTOOLS),
    "DEAP's genetic search, 8 headings a point": (evolved, NO_DEAP),
}


def without_parts(size: Size, found: Sequence[Timed]) -> Iterator[Measurement]:
    """The search without each of its parts."""
    for part, names in PARTS.items():
        with without(names):
            spoilt = [proved(size, random_tour(size, seed)) for seed in range(len(found))]
        closed = sum(each.result.closed for each in spoilt)
        ours = median(proof.seconds for proof in found)
        theirs = median(each.seconds for each in spoilt)
        gaps = [1.0 - each.result.low / each.result.high for each in spoilt]
        yield Measurement(
            f"without {part}: {named(size)}",
            ours=ours,
            peer=theirs,
            unit="s",
            ratio=theirs / ours,
            note=f"peer / ours; {closed} of {len(found)} closed, gap at most {max(gaps):.0e}",
        )


def _first_order(stops: Stops, *_: Any) -> list[tuple[int, ...]]:
    return [tuple(range(len(stops.points)))]


def _leave_out_none(sets: Any, lasts: Any, costs: Any, to_go: FloatArray, *rest: Any) -> Any:
    return leave_out(sets, lasts, costs, np.full_like(to_go, -1e9), *rest)


def _search_to_the_end(*values: Any, cutoff: float, **options: Any) -> Any:
    return search(*values, **options)


# parts of the search, and what stands in their place: names of its modules or its class
PARTS: dict[str, dict[str, Any]] = {
    "prices": {"_ROUNDS": 1, "_LATER_ROUNDS": 1},
    "costs to go": {"leave_out": _leave_out_none},
    "slopes": {"_aim": lambda search: None},
    "a cutoff": {"search": _search_to_the_end},
    "a first tour": {"short_orders": _first_order},
}


@contextmanager
def without(names: dict[str, Any]) -> Iterator[None]:
    """Replace parts of the search by something else."""
    with ExitStack() as stack:
        for name, value in names.items():
            owners = (tour_search._TourSearch, tour_search, orders)
            owner = next(owner for owner in owners if hasattr(owner, name))
            stack.enter_context(patch.object(owner, name, value))
        yield
