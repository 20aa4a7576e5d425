"""Rows of a benchmark, and timing side by side.

A benchmark is a module `benchmarks/bench_NAME.py` with a function

    def measure() -> Iterable[Measurement]: ...

Each `Measurement` is one row of the table that `python -m benchmarks` prints. A ratio is of two
times taken in the same run, their repeats interleaved, so that both meet the same machine. The
least of the repeats is compared where the machine may be shared: what else runs only ever adds,
and adds more to what runs in two threads; the note gives the ratio of medians. A peer that
is not installed is a row as well: `absent("kernel against OMPL", "ompl is not installed")`.

A size is `N = sized(1_000_000, 1_000)`: the usual one, and the least that runs all of the code.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import NamedTuple

peer_sources: Path | None = None  # the folder of the clones that `route_peers` builds
smallest = False  # whether the benchmarks imported from now on have their smallest size


def sized(usual: int, least: int) -> int:
    """The usual size, or a small one.

    The small one is taken where only the code is tried.
    """
    return least if smallest else usual


@dataclass(frozen=True)
class Measurement:
    """One comparison.

    Args:
        what: what is compared, with the size of the data.
        ours, peer: the two quantities in `unit`; None where there is nothing to compare with.
        unit: of both, e.g. `ns/row`.
        ratio: what the target is about, e.g. ours / peer or peer / ours.
        target: the bound on `ratio`; None if there is none.
        at_most: whether the ratio should be at most the target, or at least.
        note: anything that a reader needs, e.g. which ratio, or the minima.
        failed: whether the benchmark itself raised; the note says what.
    """

    what: str
    ours: float | None = None
    peer: float | None = None
    unit: str = ""
    ratio: float | None = None
    target: float | None = None
    at_most: bool = True
    note: str = ""
    failed: bool = False

    @property
    def ok(self) -> bool | None:
        """Whether the target is met.

        None where nothing was measured or no target is set.
        """
        if self.failed:
            return False
        if self.ratio is None or self.target is None:
            return None
        return self.ratio <= self.target if self.at_most else self.ratio >= self.target


def absent(what: str, reason: str) -> Measurement:
    """Row of a comparison that cannot be made."""
    return Measurement(what, note=reason)


class Timing(NamedTuple):
    """Seconds of one call over the repeats."""

    median: float
    least: float


def side_by_side(
    functions: Mapping[str, Callable[[], object]], repeats: int = 15
) -> dict[str, Timing]:
    """Time functions in turn, `repeats` times round.

    Each is called once before, to warm up.
    """
    seconds: dict[str, list[float]] = {name: [] for name in functions}
    for function in functions.values():
        function()
    for _ in range(sized(repeats, 1)):
        for name, function in functions.items():
            began = perf_counter()
            function()
            seconds[name].append(perf_counter() - began)
    return {name: Timing(median(times), min(times)) for name, times in seconds.items()}
