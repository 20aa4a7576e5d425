"""Statistics over all attempts: each method queries DuckDB and returns a small frame."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

import duckdb
import pandas as pd
import pyarrow as pa

from dubins_study.study.check.certificate import PMP_TOLERANCE

# The closed form; its rows fill the maps of the plane.
EXACT = "analytic"
# The verdict on an answer of the presolve counts as a verdict of its own: no engine was asked.
PRESOLVED = "by presolve"
VERDICTS = ("optimal", "none exists", PRESOLVED, "longer", "misses", "none")
# Neither right nor wrong: the proven interval around the shortest length is too wide to tell. Such
# an attempt is counted by itself and enters no share.
UNDECIDED = "undecided"
# The outcome of a question that a solver does not take. It was not called, and no share counts it.
UNTAKEN = "unsupported"
# What an interval counts as one trial of a solver: repeats of it, cold and warm starts, and the
# same attempt in another experiment all depend on each other.
TRIAL = ("scenario_id", "branch")
SUCCESSES = ("optimal", "none exists")
PROOFS = ("proved", "bounded", "extremal", "none")
TIMES = ("build_s", "solve_s", "wall_s")
QUANTILES = (0.5, 0.9, 0.99, 1.0)

# Number of bins per decade in which gaps are counted, and the smallest gap. The bins are too fine
# to be visible in a figure.
_BINS, _LEAST_GAP = 200, 1e-16


class Database:
    """Attempts as DuckDB's table `attempts`; its column `place` numbers the rows."""

    def __init__(self, rows: pa.Table) -> None:
        self._answers: dict[tuple[str, str], pd.DataFrame] = {}
        self._connection = duckdb.connect(config={"threads": 1})
        self._connection.register("given", rows.append_column("place", pa.array(range(len(rows)))))
        self._connection.execute("CREATE TABLE attempts AS SELECT * FROM given")
        self._connection.unregister("given")

    def frame(self, query: str, parameters: Sequence[Any] = ()) -> pd.DataFrame:
        """The result of a query; that of a repeated query is cached."""
        key = query, repr(parameters)
        if key not in self._answers:
            result = self._connection.sql(query, params=list(parameters))
            self._answers[key] = result.to_arrow_table().to_pandas()
        return self._answers[key]


class Attempts:
    """The attempts of some experiments, without duplicates, in a database.

    A question that a solver does not take is no attempt (`untaken` counts them).
    """

    def __init__(self, database: Database, experiments: Collection[str]) -> None:
        self._database = database
        self.experiments = sorted(experiments)
        self.count = int(self.frame("SELECT count(*) AS n FROM chosen")["n"].iloc[0])

    def only(self, experiments: Collection[str]) -> Attempts:
        """The attempts of some of these experiments."""
        return Attempts(self._database, set(experiments) & set(self.experiments))

    def times(self) -> pd.DataFrame:
        """Questions that have a path: one row per solver that has cold attempts at them.

        Columns: solver, timed (number of attempts), and for each of `TIMES` its median (s), lower
        quartile (`_q1`) and upper quartile (`_q3`).
        """
        quartiles = ", ".join(
            f"quantile_cont({name}, {q}) AS {name}{end}"
            for name in TIMES
            for q, end in ((0.25, "_q1"), (0.5, ""), (0.75, "_q3"))
        )
        return self.frame(
            f"""SELECT solver, count(wall_s) AS timed, {quartiles} FROM chosen
            WHERE initial_guess = 'cold' AND answerable GROUP BY solver HAVING timed > 0"""
        )

    def gap_quantiles(self) -> pd.DataFrame:
        """Gap quantiles for questions that have an answer: one row per solver and region.

        The region `all` joins all regions. The gap of an attempt that does not arrive counts as
        infinite. Quantiles are values that occur, without interpolation.

        Columns: solver, region, attempts, arrived (attempts), and q50, q90, q99, q100.
        """
        names = [f"q{100 * q:g}" for q in QUANTILES]
        # With decimal shares DuckDB computes the positions of the quantiles in whole numbers.
        shares = ", ".join(f"{q:.2f}" for q in QUANTILES)
        frame = self.frame(
            f"""SELECT solver, {_REGION} AS region, count(*) AS attempts, count(gap) AS arrived,
                quantile_disc({_GAP}, [{shares}]) AS gaps
            FROM chosen WHERE answerable
            GROUP BY GROUPING SETS ((solver, region), (solver))"""
        )
        lists = pd.DataFrame(frame["gaps"].tolist(), index=frame.index, columns=names)
        return frame.drop(columns="gaps").join(lists)

    def gap_profile(self) -> pd.DataFrame:
        """Number of attempts per bin of gaps, for questions that have an answer.

        A bin is named by its upper end; the last bin, with an infinite end, holds the attempts that
        do not arrive.

        Columns: solver, gap (ascending), attempts.
        """
        frame = self.frame(
            f"""SELECT solver, ceil({_BINS} * log10(greatest({_GAP}, {_LEAST_GAP}))) AS bin,
                count(*) AS attempts
            FROM chosen WHERE answerable GROUP BY solver, bin ORDER BY solver, bin"""
        )
        return frame.assign(gap=10.0 ** (frame["bin"] / _BINS))[["solver", "gap", "attempts"]]

    def proofs(self) -> pd.DataFrame:
        """One row per solver; a value that none of its rows has is null.

        Columns: solver, attempts, certified (attempts), one count per proof; pmp_residual (largest
        among the right answers), cut_margin (smallest among the right answers to `best`, rad);
        multipliers (answers whose multipliers can be compared), costate_median and costate_error
        (median and largest error of those); bounds (attempts with a lower bound), false_bounds;
        enclosed (attempts whose reference length has proven bounds), open (those of them whose
        bounds are apart by more than a hundredth: the data leave open on which side of a jump the
        target lies) and width (largest relative distance of the other bounds).
        """
        counts = ", ".join(f"count(*) FILTER (proof = '{p}') AS \"{p}\"" for p in PROOFS[:-1])
        return self.frame(
            f"""SELECT solver, count(*) AS attempts, count(proof) AS certified, {counts},
                count(*) FILTER (proof IS NULL OR proof NOT IN {PROOFS[:-1]}) AS "none",
                max(pmp_residual) FILTER ({_RIGHT}) AS pmp_residual,
                min(cut_margin) FILTER ({_RIGHT} AND branch = 'best') AS cut_margin,
                count(*) FILTER ({_COMPARED}) AS multipliers,
                median(costate_error) FILTER ({_COMPARED}) AS costate_median,
                max(costate_error) FILTER ({_COMPARED}) AS costate_error,
                count(lower_bound) AS bounds,
                count(*) FILTER (false_bound) AS false_bounds,
                count({_WIDTH}) FILTER (reference_high > 0) AS enclosed,
                count(*) FILTER (reference_high > 0 AND {_WIDTH} > {_OPEN}) AS open,
                max({_WIDTH}) FILTER (reference_high > 0 AND {_WIDTH} <= {_OPEN}) AS width
            FROM chosen GROUP BY solver"""
        )

    def values(self, column: str) -> list[Any]:
        """The distinct values of a column, sorted and without nulls."""
        query = f'SELECT DISTINCT "{column}" AS v FROM chosen WHERE v IS NOT NULL ORDER BY v'
        return self.frame(query)["v"].tolist()

    def frame(self, query: str) -> pd.DataFrame:
        """The result of a query; in the query, `chosen` is the table of these attempts."""
        return self._database.frame(
            f"""WITH asked AS (SELECT * FROM attempts WHERE list_contains(?, experiment)),
            chosen AS (SELECT {_ENGINES_OWN} FROM asked WHERE outcome IS DISTINCT FROM '{UNTAKEN}')
            {query}""",
            [self.experiments],
        )

    def untaken(self) -> pd.DataFrame:
        """The solvers that do not take some of the questions: solver, questions."""
        return self.frame(
            f"""SELECT solver, count(*) AS questions FROM asked WHERE outcome = '{UNTAKEN}'
            GROUP BY solver ORDER BY questions DESC, solver"""
        )


# What the presolve answered correctly is no success of an engine.
_ENGINES_OWN = f"""* REPLACE (
    CASE WHEN presolved AND verdict = 'none exists' THEN '{PRESOLVED}' ELSE verdict END AS verdict)
"""
# DuckDB's `greatest` ignores nulls, so a null is replaced explicitly.
_GAP = "CASE WHEN gap IS NULL THEN 'inf'::DOUBLE ELSE greatest(gap, 0.0) END"
_REGION = "CASE WHEN GROUPING(region) = 1 THEN 'all' ELSE region END"
_RIGHT = f"verdict IN {SUCCESSES}"
# Multipliers can be compared with costates only if the path arrives and is an extremal; those of a
# path that does not arrive are at best a proof of infeasibility. A single arc is excluded too:
# only nu3 = 0 at its end and H = 0 restrict its costates, which leaves a whole family of them.
_COMPARED = (
    "gap IS NOT NULL AND costate_error IS NOT NULL AND coalesce(word, '') NOT IN ('L', 'R') "
    f"AND pmp_residual <= {PMP_TOLERANCE}"
)
# Relative width of the enclosure; it is not defined for a length of zero.
_WIDTH = "(reference_high - reference_low) / reference_high"
_OPEN = 0.01
