"""The time that solvers need to prove their answers."""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.data.attempts import PROOFS
from dubins_study.report.paper.printed import PROBLEMS
from dubins_study.report.statistics.metrics import by_solver, proof, solver_order, success

ENOUGH = 1e-4  # proven gap up to which the check would call an answer optimal
PAPER = "the paper's problems"
_QUESTION = ["scenario_id", "branch", "initial_guess"]


def target_group(rows: pd.DataFrame) -> pd.Series[str]:
    """The group of each row: one for the paper's problems, otherwise the label."""
    return rows["label"].where(~rows["label"].isin(PROBLEMS), PAPER)


def proven_gap(rows: pd.DataFrame) -> pd.Series[float]:
    """(length - lower_bound) / length for answers that arrive with a true bound; NaN for others.

    A bound may exceed the length by rounding; the gap is then 0. A false bound proves nothing.
    """
    has_bound = (
        rows["gap"].notna() & rows["lower_bound"].notna() & ~_false(rows) & (rows["length"] > 0)
    )
    gap = (rows["length"] - rows["lower_bound"]) / rows["length"]
    return gap.clip(lower=0).where(has_bound)


def _false(rows: pd.DataFrame) -> pd.Series[bool]:
    return rows["false_bound"].fillna(False).astype(bool)


def provers(rows: pd.DataFrame) -> list[str]:
    """The solvers that give a lower bound with any answer."""
    return solver_order(rows.loc[rows["lower_bound"].notna(), "solver"].tolist())


def proofs(rows: pd.DataFrame) -> pd.DataFrame:
    """One row per solver.

    Columns: solver, attempts, one count per proof of the certificate, success (share), own_bound
    (share of attempts whose own bound proves a gap of at most 1e-4), gap and gap_most (median and
    largest proven gap), wall_s with quartiles wall_s_q1 and wall_s_q3 (s), build_s (median, s).
    """
    gap = proven_gap(rows)
    counts = pd.get_dummies(proof(rows)).reindex(columns=list(PROOFS), fill_value=0)
    measured = rows.assign(success=success(rows), own_bound=gap <= ENOUGH, proven=gap)
    groups = measured.join(counts).groupby("solver")
    frame = pd.DataFrame(
        {
            "attempts": groups.size(),
            **{name: groups[name].sum() for name in PROOFS},
            "success": groups["success"].mean(),
            "own_bound": groups["own_bound"].mean(),
            "gap": groups["proven"].median(),
            "gap_most": groups["proven"].max(),
            "wall_s_q1": groups["wall_s"].quantile(0.25),
            "wall_s": groups["wall_s"].median(),
            "wall_s_q3": groups["wall_s"].quantile(0.75),
            "build_s": groups["build_s"].median(),
        }
    )
    return by_solver(frame.reset_index())


def prices(rows: pd.DataFrame) -> pd.DataFrame:
    """Each solver's time divided by that of the fastest right answer without a proof.

    The ratios are formed per question from medians over repeats. A question counts only if the
    solver is right in every repeat and a solver without bounds is too. One row per solver and group
    of `target_group`.

    Columns: group, solver, questions, ratio (median), ratio_q1, ratio_q3.
    """
    timed = rows.assign(right=success(rows), group=target_group(rows))
    table = timed.groupby(["group", *_QUESTION, "solver"]).agg(
        wall=("wall_s", "median"), ok=("right", "all")
    )
    wide = pd.DataFrame(table["wall"].where(table["ok"]).unstack("solver"))
    plain = [solver for solver in wide.columns if solver not in provers(rows)]
    ratios = wide.div(wide[plain].min(axis=1), axis=0)
    records = []
    groups = sorted(set(ratios.index.get_level_values("group")), key=lambda g: (g != PAPER, g))
    for name in groups:
        group = ratios.xs(name, level="group")
        for solver in solver_order(list(group.columns)):
            known = group[solver].dropna()
            if known.empty:
                continue
            low, middle, high = np.quantile(known, [0.25, 0.5, 0.75])
            records.append((name, solver, len(known), low, middle, high))
    columns = ["group", "solver", "questions", "ratio_q1", "ratio", "ratio_q3"]
    return pd.DataFrame.from_records(records, columns=columns)


def fastest(rows: pd.DataFrame) -> tuple[str, float]:
    """The solver without bounds that is most often the fastest right one, and its share.

    The share is of the questions that any of these solvers answers correctly; ("", NaN) if there is
    no such question.
    """
    plain = rows[~rows["solver"].isin(provers(rows))]
    right = plain[success(plain)]
    if right.empty:
        return "", float("nan")
    median = right.groupby([*_QUESTION, "solver"])["wall_s"].median().unstack("solver")
    first = median.idxmin(axis=1).value_counts(normalize=True)
    often = float(first.max())
    return solver_order([str(name) for name in first.index[first == often]])[0], often
