"""Verdicts counted over all attempts: on questions that have a path, and on those that have none.

Finding a path and finding out that none exists are different tasks, so they are counted apart. The
number of questions that a solver answered right counts repeats as parts: a question that is
answered right in two of three repeats counts 2/3.
"""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.attempts import PRESOLVED, SUCCESSES, VERDICTS, Attempts


def methods(attempts: Attempts) -> pd.DataFrame:
    """One row per solver: solver, formulation, engine, guess; several guesses are joined by or."""
    names = ("formulation", "engine", "guess")
    joined = ", ".join(
        f"coalesce(string_agg(DISTINCT {name}, ' or ' ORDER BY {name}), 'not stated') AS {name}"
        for name in names
    )
    return attempts.frame(f"SELECT solver, {joined} FROM chosen GROUP BY solver")


def verdicts(attempts: Attempts) -> pd.DataFrame:
    """Attempts at questions that have a path: one row per solver, zeros if it has none.

    Columns: solver, attempts, questions, right (questions answered right), the attempts with each
    verdict, false_claims, wrong_basins, not_returned (timeout, crashed, raised, ...), wall_s
    (median, s).
    """
    counts = {f'"{verdict}"': f"verdict = '{verdict}'" for verdict in VERDICTS}
    counts |= {"false_claims": "false_claim", "wrong_basins": "wrong_basin"}
    counts |= {"not_returned": "outcome IS DISTINCT FROM 'returned'"}
    counted = ", ".join(
        f"count(*) FILTER (answerable AND {condition}) AS {name}"
        for name, condition in counts.items()
    )
    return attempts.frame(
        f"""SELECT solver, count(*) FILTER (answerable) AS attempts,
            {_questions("answerable")} AS questions,
            {_questions(f"answerable AND {_RIGHT}")} AS "right", {counted},
            {attempts.quantile("wall_s", 0.5)} FILTER (answerable) AS wall_s
        FROM {_weighted(attempts)} GROUP BY solver"""
    )


def evaluations(attempts: Attempts) -> pd.DataFrame:
    """Median function evaluations of an attempt at a question that has a path: solver, evaluations.

    Null where no attempt counts them.
    """
    median = attempts.quantile("evaluations", 0.5)
    return attempts.frame(
        f"SELECT solver, {median} FILTER (answerable) AS evaluations FROM chosen GROUP BY solver"
    )


KINDS = ("presolved", "unasked", "right", "wrong", "silent")


def existence(attempts: Attempts) -> pd.DataFrame:
    """Questions without a path, and paths that are denied: one row per solver.

    Columns: solver; of the questions without a path: presolved, unasked (the solver does not answer
    such a branch, or is not installed), right, wrong (a false claim), silent (no claim); wall_s
    (median of the attempts that reached the engine, s), presolve_s (median of the presolved ones,
    s); of those that have a path: questions, denied (claimed infeasible).
    """
    counted = ", ".join(f"{_questions(_is_kind(kind))} AS {kind}" for kind in KINDS)
    engine = "kind IN ('right', 'wrong', 'silent')"
    denied = "answerable AND claim = 'infeasible' AND false_claim"
    return attempts.frame(
        f"""SELECT solver, {counted},
            {attempts.quantile("wall_s", 0.5)} FILTER ({engine}) AS wall_s,
            {attempts.quantile("wall_s", 0.5)} FILTER (kind = 'presolved') AS presolve_s,
            {_questions("answerable")} AS questions, {_questions(denied)} AS denied
        FROM (SELECT *, {_KIND} AS kind FROM {_weighted(attempts)}) GROUP BY solver"""
    )


_RIGHT = f"verdict IN {SUCCESSES}"
_KIND = f"""CASE WHEN answerable THEN NULL WHEN verdict = '{PRESOLVED}' THEN 'presolved'
    WHEN outcome IN ('unsupported', 'unavailable') THEN 'unasked'
    WHEN {_RIGHT} THEN 'right' WHEN false_claim THEN 'wrong' ELSE 'silent' END"""
_QUESTION = "experiment, solver, profile, scenario_id, branch, initial_guess"


def _weighted(attempts: Attempts) -> str:
    """The query of the attempts with a `weight` that is 1 over the repeats of their question."""
    weight = "1.0"
    if len(attempts.values("repeat")) > 1:
        weight = f"1.0 / count(*) OVER (PARTITION BY {_QUESTION})"
    return f"(SELECT *, CAST({weight} AS DOUBLE) AS weight FROM chosen)"


def _questions(condition: str) -> str:
    """A number of questions, rounded, since the last digits of a sum depend on its order."""
    return f"coalesce(round(sum(weight) FILTER ({condition}), 6), 0.0)"


def _is_kind(kind: str) -> str:
    return f"kind = '{kind}'"
