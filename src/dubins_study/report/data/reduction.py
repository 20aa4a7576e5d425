"""What the numbers over all attempts need, reduced part by part.

`of(rows)` reduces rows, `merge` unites reductions: associative and commutative, so that any parts
in any order give what the whole gives. The numbers themselves are made in `report.statistics.metrics`,
`report.statistics.timing` and `report.topics.certificates.numbers`, for few rows and many alike.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import pandas as pd

from dubins_study.report.data.plane_map import PlaneMap
from dubins_study.report.data.tally import TIMES, Tally, tally, united
from dubins_study.study.scenario import COLUMNS

EXACT = "analytic"


@dataclass(frozen=True, eq=False)
class Reduction:
    """All attempts.

    Args:
        tallies: (experiment, solver) -> its numbers.
        planes: experiment -> where the closed form's answers to the branch best lie.
    """

    tallies: Mapping[tuple[str, str], Tally] = field(default_factory=dict)
    planes: Mapping[str, PlaneMap] = field(default_factory=dict)

    def merge(self, other: Reduction) -> Reduction:
        """Both together."""
        return merged([self, other])

    def only(self, experiments: Collection[str]) -> Reduction:
        """Some experiments."""
        names = set(experiments)
        tallies = {key: own for key, own in self.tallies.items() if key[0] in names}
        return Reduction(tallies, {name: p for name, p in self.planes.items() if name in names})

    @cached_property
    def experiments(self) -> list[str]:
        """Names of the experiments."""
        return sorted({experiment for experiment, _ in self.tallies})

    @cached_property
    def solvers(self) -> dict[str, Tally]:
        """Every solver's attempts in all experiments."""
        found: dict[str, list[Tally]] = {}
        for (_, solver), own in self.tallies.items():
            found.setdefault(solver, []).append(own)
        return {solver: united(tallies) for solver, tallies in found.items()}

    @cached_property
    def total(self) -> Tally:
        """All attempts."""
        return united(list(self.tallies.values()))


def merged(reductions: Iterable[Reduction]) -> Reduction:
    """All of them together."""
    found: dict[tuple[str, str], list[Tally]] = {}
    maps: dict[str, list[PlaneMap]] = {}
    for reduction in reductions:
        for key, own in reduction.tallies.items():
            found.setdefault(key, []).append(own)
        for experiment, plane in reduction.planes.items():
            maps.setdefault(experiment, []).append(plane)
    tallies = {key: united(each) for key, each in found.items()}
    return Reduction(tallies, {name: PlaneMap.merged(each) for name, each in maps.items()})


# the columns that are read; a missing one is taken for one without values
NEEDED = (
    *(
        "experiment",
        "solver",
        "branch",
        "initial_guess",
        "region",
        "word",
        "reference_word",
        *COLUMNS,
    ),
    *("outcome", "claim", "verdict", "false_claim", "wrong_basin", "native_status", "message"),
    *("length", "gap", "proof", "lower_bound", "reference_low", "reference_high", "false_bound"),
    *("pmp_residual", "cut_margin", "costate_error", *TIMES, "jobs", "threads"),
)


def of(rows: pd.DataFrame) -> Reduction:
    """Reduce rows: the columns of `NEEDED`, which are those of `study.rows.schema` and `experiment`."""
    needed = rows.reindex(columns=list(NEEDED)).reset_index(drop=True)
    groups = needed.groupby(["experiment", "solver"], observed=True, sort=False)
    tallies = {(str(e), str(s)): tally(own) for (e, s), own in groups}
    exact = needed[(needed["solver"] == EXACT) & (needed["branch"] == "best")]
    mapped = exact.groupby("experiment", observed=True, sort=False)
    return Reduction(tallies, {str(name): PlaneMap.of(own) for name, own in mapped})
