"""Choose the attempts that the page embeds: the worst of each solver, and some of every stratum."""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.data.attempts import PRESOLVED, SUCCESSES, Attempts
from dubins_study.study.rows.schema import ROW

# Attempts of each solver that are always embedded.
WORST = 10

_KINDS = {"string": "text", "bool": "flag"}
_PLOTTED = {c.name: _KINDS.get(c.type, "number") for c in ROW if c.plotted}
TEXTS = ("experiment", *(name for name, kind in _PLOTTED.items() if kind == "text"))
SCENARIO = ("x", "y", "heading", "target_x", "target_y", "radius", "speed")
MEASURED = tuple(name for name, kind in _PLOTTED.items() if kind == "number")
FLAGS = tuple(name for name, kind in _PLOTTED.items() if kind == "flag")

_MOST_OF_A_STRATUM = 100_000  # DuckDB's min_by takes less than a million


def sample(attempts: Attempts, most: int) -> pd.DataFrame:
    """The worst attempts of each solver, and about `most` others, spread evenly over the strata.

    A stratum is what one solver made of one region with one verdict. Of each stratum the first
    attempts by scenario are taken: a scenario's id is a hash, so they are a random sample, and
    those of two solvers are at the same scenarios where they can be. Only the first repeat of a
    question is taken.

    Returns:
        Columns: `TEXTS`, `SCENARIO`, `MEASURED`, `FLAGS`, repeat, curvatures and lengths (arrays),
        worst (rank among the solver's worst, 1 to `WORST`; 0 for others). Sorted by solver and
        question.
    """
    strata = attempts.frame(f"SELECT count(*) AS n {_STRATA}")["n"].to_numpy()
    share = _largest_share(strata, most)
    repeats = 1 + max(attempts.values("repeat"), default=0)
    columns = [*TEXTS, *SCENARIO, *MEASURED, *FLAGS, "repeat", "curvatures", "lengths"]
    rows = attempts.frame(
        f""", spread AS (SELECT unnest(min_by(place, {_ORDER}, {share})) AS place {_STRATA}),
        candidates AS (
            SELECT unnest(max_by(place, {_BADNESS}, {WORST * repeats})) AS place
            FROM chosen GROUP BY solver),
        picked AS MATERIALIZED (
            SELECT place, bool_or(is_spread) AS spread, bool_or(NOT is_spread) AS candidate
            FROM (SELECT *, true AS is_spread FROM spread
                UNION ALL SELECT *, false AS is_spread FROM candidates)
            GROUP BY place)
        SELECT {", ".join(columns)}, {_LEVEL} AS level, {_SIZE} AS size, spread, candidate
        FROM chosen JOIN picked USING (place)
        ORDER BY solver, scenario_id, branch, experiment, initial_guess, profile, repeat"""
    )
    rows = rows.assign(worst=_ranks(rows))
    return rows[rows["spread"] | (rows["worst"] > 0)].reset_index(drop=True)


def _largest_share(strata: np.ndarray, most: int) -> int:
    """The largest number of attempts that each stratum may have, if `most` is to hold for all."""
    shares = np.unique(np.append(strata, np.arange(1, 200)))
    sums = np.array([np.minimum(strata, share).sum() for share in shares])
    fitting = shares[sums <= most]
    return int(np.clip(fitting.max(initial=1), 1, _MOST_OF_A_STRATUM))


def _ranks(rows: pd.DataFrame) -> np.ndarray:
    """The rank of each row among its solver's worst, one row a question; 0 beyond `WORST`."""
    question = ["solver", "experiment", "scenario_id", "branch", "initial_guess", "profile"]
    order = ["level", "size", "scenario_id", "branch", "repeat"]
    worst = rows[rows["candidate"]].sort_values(order, ascending=[False] * 4 + [True])
    rank = worst.drop_duplicates(question).groupby("solver", sort=False).cumcount() + 1
    return rank[rank <= WORST].reindex(rows.index, fill_value=0).to_numpy()


# A false claim is worse than a longer path, that than a path that misses, that than none at all.
_LEVEL = f"""CASE WHEN false_claim THEN 4 WHEN verdict = 'longer' THEN 3
    WHEN verdict = 'misses' THEN 2 WHEN verdict IN {(*SUCCESSES, PRESOLVED)} THEN 0 ELSE 1 END"""
_SIZE = """greatest(coalesce(gap, 0.0), coalesce(miss / radius, 0.0),
    coalesce(curvature_excess, 0.0))"""
_ORDER = "{'a': scenario_id, 'b': branch, 'c': experiment, 'd': initial_guess, 'e': profile}"
_BADNESS = f"{{'a': {_LEVEL}, 'b': {_SIZE}, 'c': scenario_id, 'd': branch, 'e': -repeat}}"
_STRATA = "FROM chosen WHERE repeat = 0 GROUP BY solver, region, verdict"
