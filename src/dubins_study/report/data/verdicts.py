"""Verdicts counted over all attempts: on questions that have a path, and on those that have none.

Finding a path and finding out that none exists are different tasks, so they are counted apart. A
number of questions counts trials, each a scenario and a branch (`report.data.attempts.TRIAL`): all
attempts of a solver at it are parts of one. Of two right attempts in three it has 2/3 of a question
right, whether the three are repeats, or a cold and two warm starts.
"""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.attempts import (
    PRESOLVED,
    SUCCESSES,
    TRIAL,
    UNDECIDED,
    VERDICTS,
    Attempts,
)


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
    verdict, those that are undecided (which are no attempts here), false_claims, wrong_basins,
    not_returned (timeout, crashed, raised, ...), wall_s (median, s; null if no attempt returned).
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
            {_questions("answerable")} AS questions, {_UNDECIDED} AS {UNDECIDED},
            {_questions(f"answerable AND {_RIGHT}")} AS "right", {counted},
            CASE WHEN bool_or(outcome = 'returned') FILTER (answerable)
                THEN median(wall_s) FILTER (answerable) END AS wall_s
        FROM {_weighted(attempts)} GROUP BY solver"""
    )


def starts(attempts: Attempts) -> pd.DataFrame:
    """Questions that have a path and that a solver was asked both cold and warm.

    Columns: solver, initial_guess (cold or warm), questions, right.
    """
    trial = f"PARTITION BY solver, {', '.join(TRIAL)}"
    both = " AND ".join(
        f"bool_or(initial_guess = '{start}') OVER ({trial})" for start in ("cold", "warm")
    )
    # Without a warm attempt nothing is sorted: that would take memory for very many rows.
    asked = f"({both})" if "warm" in attempts.values("initial_guess") else "false"
    return attempts.frame(
        f"""SELECT solver, initial_guess, {_questions("true")} AS questions,
            {_questions(_RIGHT)} AS "right"
        FROM (SELECT *, {asked} AS asked FROM {_weighted(attempts, "initial_guess")})
        WHERE asked AND answerable AND initial_guess IN ('cold', 'warm')
        GROUP BY solver, initial_guess ORDER BY solver, initial_guess"""
    )


def evaluations(attempts: Attempts) -> pd.DataFrame:
    """Median function evaluations of an attempt at a question that has a path: solver, evaluations.

    Null where no attempt counts them.
    """
    return attempts.frame(
        """SELECT solver, median(evaluations) FILTER (answerable) AS evaluations
        FROM chosen GROUP BY solver"""
    )


KINDS = ("presolved", "unasked", "right", "wrong", "silent")


def existence(attempts: Attempts) -> pd.DataFrame:
    """Questions without a path, and paths that are denied: one row per solver.

    Columns: solver; of the questions without a path: presolved, unasked (the solver is not
    installed), right, wrong (a false claim), silent (no claim); wall_s
    (median of the attempts that reached the engine, s), presolve_s (median of the presolved ones,
    s); of those that have a path: questions, denied (claimed infeasible).
    """
    counted = ", ".join(f"{_questions(f'kind = {kind!r}')} AS {kind}" for kind in KINDS)
    engine = "kind IN ('right', 'wrong', 'silent')"
    denied = "answerable AND claim = 'infeasible' AND false_claim"
    return attempts.frame(
        f"""SELECT solver, {counted},
            median(wall_s) FILTER ({engine}) AS wall_s,
            median(wall_s) FILTER (kind = 'presolved') AS presolve_s,
            {_questions("answerable")} AS questions, {_questions(denied)} AS denied
        FROM (SELECT *, {_KIND} AS kind FROM {_weighted(attempts)}) GROUP BY solver"""
    )


_RIGHT = f"verdict IN {SUCCESSES}"
_UNDECIDED = f"count(*) FILTER (verdict = '{UNDECIDED}')"
_KIND = f"""CASE WHEN answerable OR verdict = '{UNDECIDED}' THEN NULL
    WHEN verdict = '{PRESOLVED}' THEN 'presolved'
    WHEN outcome = 'unavailable' THEN 'unasked'
    WHEN {_RIGHT} THEN 'right' WHEN false_claim THEN 'wrong' ELSE 'silent' END"""
# Columns that tell attempts of one solver at one trial apart.
_VARIED = ("repeat", "initial_guess", "profile", "experiment")


def _weighted(attempts: Attempts, also: str = "") -> str:
    """The query of the attempts with a `weight` that is 1 over the attempts at their trial.

    The values of the column `also`, such as the initial guess, are trials of their own.
    """
    weight = "1.0"
    # Where no two attempts are at one trial, to look for pairs would take memory.
    if any(len(attempts.values(name)) > 1 for name in _VARIED):
        key = ", ".join(("solver", *TRIAL, *filter(None, [also])))
        weight = f"1.0 / count(*) OVER (PARTITION BY {key})"
    return f"(SELECT *, CAST({weight} AS DOUBLE) AS weight FROM chosen)"


def _questions(condition: str) -> str:
    """A number of questions, rounded, since the last digits of a sum depend on its order."""
    return f"coalesce(round(sum(weight) FILTER ({condition}), 6), 0.0)"
