"""The section on what a proof costs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

import numpy as np
import pandas as pd

from dubins_study.report.data.attempts import EXACT, PROOFS
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, Column, columns
from dubins_study.report.elements.content import Picture, Section, Show, Table, Topic
from dubins_study.report.elements.formats import count, digits, seconds, sentences, share
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.plots import Mark, quartile_lines
from dubins_study.report.elements.style import BLUE, GREEN, VERMILION
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
TIME = (Mark("wall_s"),)
_LOOKS = ((BLUE, "o"), (VERMILION, "s"), (GREEN, "^"))  # of groups of targets
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


Names: TypeAlias = Mapping[str, str]  # solver -> its name in the section


def proofs_section(results: Results) -> Section | None:
    """Times, proofs and the price of the solvers' own bounds."""
    rows = results.rows
    if rows.empty:
        return None
    table, price = proofs(rows), prices(rows)
    palette = Palette.of_page(results)
    names = palette.names(rows["solver"])
    blocks: list[Picture | Table] = [_time_picture(table, palette)]
    if len(price):
        blocks.append(_price_picture(price, palette))
        repeats = "The ratios of the figure; only questions that the solver answers correctly."
        blocks.append(Table("proofs-price", repeats, price, PRICES, show=Show.FILE))
    caption = (
        "Proved to none: the certificate's words. Own bound: attempts whose own lower bound leaves "
        "(length − bound) / length at 1e-4 or less; the closed form's bound is its length."
    )
    blocks.append(Table("proofs", caption, table, PROOF_COLUMNS, dense=True))
    text = (
        "A solver's lower bound proves the solver's own answer; a certificate proves the answer of "
        "any solver, afterwards."
    )
    text = sentences(
        text,
        _own_bounds(rows, table, names),
        _price(rows, price, names),
        _certified(rows, table, names),
    )
    lead = (
        "Compare a solver that proves its own answer with the fastest right answer without a "
        "proof: the ratio is the price, and a certificate afterwards is the other way to a proof."
    )
    return Section("proofs", "What a proof costs", text, tuple(blocks), lead)


def _paid(rows: pd.DataFrame) -> list[str]:
    """Solvers with bounds, except the closed form, whose bound is its length."""
    return [solver for solver in provers(rows) if solver != EXACT]


def _own_bounds(rows: pd.DataFrame, table: pd.DataFrame, names: Names) -> str:
    parts = [
        f"{names[row['solver']]} proves {share(row['own_bound'])} of its answers to 1e-4 "
        f"or closer (largest proven gap {digits(2)(row['gap_most'])}), in {seconds(row['wall_s'])} "
        f"(median), {seconds(row['build_s'])} of them building"
        for row in table[table["solver"].isin(_paid(rows))].to_dict("records")
    ]
    return f"By its own bound {'; '.join(parts)}." if parts else ""


def _price(rows: pd.DataFrame, price: pd.DataFrame, names: Names) -> str:
    first, often = fastest(rows)
    parts = []
    for solver in _paid(rows):
        group = price[price["solver"] == solver]
        if len(group):
            items = ", ".join(
                f"{digits(2)(row['ratio'])} ({row['group']})" for row in group.to_dict("records")
            )
            parts.append(f"{names[solver]} {items}")
    if not parts:
        return ""
    return (
        "Its price, as a multiple of the time of the fastest right answer without one "
        f"({names[first]} on {share(often)} of the questions): {'; '.join(parts)}."
    )


def _certified(rows: pd.DataFrame, table: pd.DataFrame, names: Names) -> str:
    plain = table[~table["solver"].isin(provers(rows))]
    if plain.empty:
        return ""
    full = plain[plain["proved"] == plain["attempts"]]
    rest = solver_order([solver for solver in plain["solver"] if solver not in set(full["solver"])])
    text = (
        f"The certificate proves {count(plain['proved'].sum())} of the "
        f"{count(plain['attempts'].sum())} answers of solvers that prove nothing themselves"
    )
    if len(full):
        text += f": all of {', '.join(map(names.__getitem__, full['solver']))}"
    if rest:
        items = ", ".join(
            f"{count(row['proved'])} of {count(row['attempts'])} of {names[row['solver']]}"
            for row in plain[plain["solver"].isin(rest)].to_dict("records")
        )
        text += f"{', and' if len(full) else ':'} {items}"
    return f"{text}."


def _time_picture(table: pd.DataFrame, palette: Palette) -> Picture:
    caption = (
        "Time of one cold attempt, building included: median (mark) and quartiles (bar). At the "
        "right: the shares of answers that the solver's own bound proves to 1e-4, and that the "
        "certificate proves."
    )
    proved = zip(table["own_bound"], table["proved"] / table["attempts"], strict=True)
    named = table.assign(
        name=table["solver"].map(palette.names(table["solver"])),
        note=[f"own bound {own:.0%}, certificate {certified:.0%}" for own, certified in proved],
    )
    figure = quartile_lines(named, TIME, palette, "time of one attempt", seconds=True)
    alt = "Median times and quartiles with shares of proofs, one line per solver"
    return Picture("proofs-time", caption, figure, alt)


def _price_picture(price: pd.DataFrame, palette: Palette) -> Picture:
    """A line per solver, on it a mark per group of targets."""
    caption = (
        "Time over that of the fastest right answer without a proof, question by question: median "
        "and quartiles, right answers only. Right of 1 is slower."
    )
    groups = list(dict.fromkeys(price["group"]))
    wide = price.pivot(index="solver", columns="group", values=["ratio_q1", "ratio", "ratio_q3"])
    wide.columns = [f"{key[1]}{key[0].removeprefix('ratio')}" for key in wide.columns]
    table = by_solver(wide.reset_index())
    named = table.assign(name=table["solver"].map(palette.names(table["solver"])))
    marks = [
        Mark(group, group, *_LOOKS[number % len(_LOOKS)]) for number, group in enumerate(groups)
    ]
    label = "time / fastest right answer without a proof"
    figure = quartile_lines(named, marks, palette, label, limit=1.0)
    return Picture("proofs-price", caption, figure, "Ratios of times by group of targets")


TOPIC = Topic("what a proof costs", proofs_section, "proofs")
