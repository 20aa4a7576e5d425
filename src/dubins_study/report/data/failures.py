"""Attempts that failed, counted: by what happened, by what was said, and by where the target lies.

A failure is an attempt at a question that has a path, without an answer that the check accepts.
"""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.attempts import PRESOLVED, SUCCESSES, Attempts
from dubins_study.report.data.command import ROUTE

# Outcomes other than `returned`: what may happen to the process that is asked.
OUTCOMES = ("timeout", "crashed", "raised", "out_of_memory", "unavailable")
# What a failure is, the first that holds.
KINDS = ("no return", "no path", "misses", "longer")
# Reach of maps of the plane, in radii from the start.
REACH = 4.0
# What names an example, in the order in which a plainer one is chosen.
_EXAMPLE = (
    *("warm", "repeat", "distance", "x", "y", "heading", "target_x", "target_y"),
    *("radius", "branch", "profile", "experiment", *ROUTE),
)
_PLAINEST = "min({" + ", ".join(f"'{name}': {name}" for name in _EXAMPLE) + "})"
_EXAMPLE_PARTS = ", ".join(f"example.{name} AS {name}" for name in _EXAMPLE)
# A number in a message, so that messages that differ in numbers count as one already here.
_NUMBER = r"\d[\d.]*(?:[eE][+-]?\d+)?"
_RIGHT = (*SUCCESSES, PRESOLVED)
_FAILED = f"answerable AND (verdict IS NULL OR verdict NOT IN {_RIGHT})"
_KIND = """CASE WHEN outcome IS DISTINCT FROM 'returned' THEN 'no return'
    WHEN verdict IN ('misses', 'longer') THEN verdict ELSE 'no path' END"""


def outcomes(attempts: Attempts) -> pd.DataFrame:
    """One row per solver: how many attempts have each of `OUTCOMES`, at any question.

    Columns: solver, attempts, each of `OUTCOMES`, and as in `failures` those of an example whose
    outcome is one of them; null if there is none.
    """
    counts = ", ".join(f"count(*) FILTER (outcome = '{name}') AS {name}" for name in OUTCOMES)
    return attempts.frame(
        f"""SELECT * EXCLUDE (example), {_EXAMPLE_PARTS} FROM (
            SELECT solver, count(*) AS attempts, {counts},
                {_PLAINEST} FILTER (outcome IN {OUTCOMES}) AS example
            FROM (SELECT *, {_DISTANCE} AS distance, {_WARM} AS warm FROM chosen) GROUP BY solver)
        ORDER BY solver"""
    )


def failures(attempts: Attempts) -> pd.DataFrame:
    """Failures, counted by what was said of them, with an example of each.

    The example is the first repeat with the nearest target, cold if there is a cold one.

    Columns: solver, outcome, claim, verdict, message (the status if there is no message; # stands
    for a number), attempts; of the example: warm, and the columns that make its question.
    """
    kinds = "solver, outcome, claim, verdict, message"
    message = f"""regexp_replace(coalesce(nullif(message, ''), native_status, ''),
        '{_NUMBER}', '#', 'g')"""
    return attempts.frame(
        f"""SELECT {kinds}, attempts, {_EXAMPLE_PARTS} FROM (
            SELECT {kinds}, count(*) AS attempts, {_PLAINEST} AS example
            FROM (SELECT * REPLACE ({message} AS message), {_DISTANCE} AS distance, {_WARM} AS warm
                FROM chosen WHERE {_FAILED})
            GROUP BY {kinds})"""
    )


def regions(attempts: Attempts) -> pd.DataFrame:
    """One row per region of the target: region, near (within `REACH`), attempts, each of `KINDS`.

    Attempts at questions that have a path. Of a question that was never judged no region is known.
    """
    return attempts.frame(
        f"""SELECT region, {_DISTANCE} <= {REACH} AS near, count(*) AS attempts, {_COUNTS}
        FROM {_WITH_KIND} WHERE answerable GROUP BY ALL ORDER BY ALL"""
    )


_WARM = "initial_guess IS DISTINCT FROM 'cold'"
_DISTANCE = "sqrt((target_x - x) ** 2 + (target_y - y) ** 2) / radius"
_WITH_KIND = f"(SELECT *, CASE WHEN {_FAILED} THEN {_KIND} END AS kind FROM chosen)"
_COUNTS = ", ".join(f"count(*) FILTER (kind = '{kind}') AS \"{kind}\"" for kind in KINDS)
