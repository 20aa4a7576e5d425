"""The section on what a proof costs."""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.data.attempts import PROOFS, is_true
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, Column, columns
from dubins_study.report.elements.content import Section, Table, Topic
from dubins_study.report.elements.formats import count, digits, seconds, sentences, share
from dubins_study.report.paper.printed import PROBLEMS
from dubins_study.report.statistics.metrics import by_solver, proof, solver_order, success

PROOF_COLUMNS = (
    SOLVER,
    *columns(count, attempts="attempts"),
    *columns(share, success="success"),
    *(Column(name, name, count) for name in PROOFS),
    *columns(share, own_bound="own bound to 1e-4"),
    *columns(digits(2), gap="proven gap, median", gap_most="largest"),
    *columns(seconds, wall_s_q1="time, 25 %", wall_s="median", wall_s_q3="75 %"),
    *columns(seconds, build_s="building"),
)
PRICES = (
    *columns(kind="text", group="targets"),
    SOLVER,
    *columns(count, questions="questions"),
    *columns(digits(2), ratio_q1="25 %", ratio="median", ratio_q3="75 %"),
)
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
    bounded = rows["gap"].notna() & rows["lower_bound"].notna() & ~is_true(rows["false_bound"])
    gap = (rows["length"] - rows["lower_bound"]) / rows["length"]
    return gap.clip(lower=0).where(bounded & (rows["length"] > 0))


def provers(rows: pd.DataFrame) -> list[str]:
    """The solvers that give a lower bound with any answer."""
    return solver_order(rows.loc[rows["lower_bound"].notna(), "solver"].tolist())


def proofs(rows: pd.DataFrame) -> pd.DataFrame:
    """One row per solver: the columns `PROOF_COLUMNS`; gap is the proven one, times in s."""
    gap = proven_gap(rows)
    counts = pd.get_dummies(proof(rows)).reindex(columns=list(PROOFS), fill_value=0)
    measured = rows.assign(success=success(rows), own_bound=gap <= ENOUGH, proven=gap)
    groups = measured.join(counts).groupby("solver")
    frame = (
        groups[list(PROOFS)]
        .sum()
        .assign(
            attempts=groups.size(),
            success=groups["success"].mean(),
            own_bound=groups["own_bound"].mean(),
            gap=groups["proven"].median(),
            gap_most=groups["proven"].max(),
            wall_s_q1=groups["wall_s"].quantile(0.25),
            wall_s=groups["wall_s"].median(),
            wall_s_q3=groups["wall_s"].quantile(0.75),
            build_s=groups["build_s"].median(),
        )
    )
    return by_solver(frame.reset_index())


def prices(rows: pd.DataFrame) -> pd.DataFrame:
    """Each solver's time divided by that of the fastest right answer without a proof: `PRICES`.

    The ratios are formed per question from medians over repeats. A question counts only if the
    solver is right in every repeat and a solver without bounds is too. One row per solver and group
    of `target_group`.
    """
    timed = rows.assign(right=success(rows), group=target_group(rows))
    table = timed.groupby(["group", *_QUESTION, "solver"]).agg(
        wall=("wall_s", "median"), ok=("right", "all")
    )
    wide = pd.DataFrame(table["wall"].where(table["ok"]).unstack("solver"))
    plain = [solver for solver in wide.columns if solver not in provers(rows)]
    ratios = wide.div(wide[plain].min(axis=1), axis=0)
    known = ratios.melt(ignore_index=False, value_name="ratio").dropna()
    each = known.groupby(["group", "solver"])["ratio"]
    ends = {
        f"ratio{end}": each.agg(np.quantile, q=q)
        for end, q in (("_q1", 0.25), ("", 0.5), ("_q3", 0.75))
    }
    table = by_solver(pd.DataFrame({"questions": each.size(), **ends}).reset_index())
    return table.sort_values("group", key=lambda g: g.where(g != PAPER, ""), kind="stable")


def proofs_section(results: Results) -> Section | None:
    """The price of the solvers' own bounds, and their proofs and times."""
    rows = results.rows
    if rows.empty:
        return None
    table, price = proofs(rows), prices(rows)
    caption = (
        "Time over that of the fastest right answer without a proof, question by question: median "
        "and quartiles, right answers only. Above 1 is slower."
    )
    blocks = [Table("proofs-price", caption, price, PRICES)] if len(price) else []
    caption = (
        "Proved to none: the certificate's words. Own bound: attempts whose own lower bound leaves "
        "(length − bound) / length at 1e-4 or less; the closed form's bound is its length."
    )
    blocks.append(Table("proofs", caption, table, PROOF_COLUMNS, dense=True))
    plain = table[~table["solver"].isin(provers(rows))]
    text = sentences(
        "A solver's lower bound proves the solver's own answer; a certificate proves the answer of "
        "any solver, afterwards.",
        f"The certificate proves {count(plain['proved'].sum())} of the "
        f"{count(plain['attempts'].sum())} answers of solvers that prove nothing themselves."
        if len(plain)
        else "",
    )
    lead = (
        "Compare a solver that proves its own answer with the fastest right answer without a "
        "proof: the ratio is the price, and a certificate afterwards is the other way to a proof."
    )
    return Section("proofs", "What a proof costs", text, tuple(blocks), lead)


TOPIC = Topic("what a proof costs", proofs_section, "proofs")
