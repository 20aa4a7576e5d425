"""The section on what a proof costs."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.attempts import EXACT, PROOFS
from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import (
    Column,
    Picture,
    Section,
    Table,
    count,
    digits,
    seconds,
    share,
)
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.style import HALF, new_figure
from dubins_study.report.statistics.metrics import solver_order
from dubins_study.report.topics.proofs.figures import plot_prices, plot_wall
from dubins_study.report.topics.proofs.numbers import (
    fastest,
    prices,
    proofs,
    provers,
)


def proofs_section(results: Results) -> Section | None:
    """Times, proofs and the price of the solvers' own bounds."""
    rows = results.rows
    if rows.empty:
        return None
    table, price = proofs(rows), prices(rows)
    blocks: list[Picture | Table] = [_time_picture(table, Palette.of(results.solvers))]
    if len(price):
        blocks.append(_price_picture(price))
    blocks.append(_table(table))
    if len(price):
        blocks.append(_price_table(price))
    text = (
        "A solver's lower bound proves its own answer; a certificate proves anybody's, after the "
        f"fact. {sentences(rows, table, price)}"
    )
    return Section("proofs", "What a proof costs", text, tuple(blocks))


def sentences(rows: pd.DataFrame, table: pd.DataFrame, price: pd.DataFrame) -> str:
    """What the study says.

    Args:
        rows: attempts.
        table, price: of `proofs.proofs` and `proofs.prices`.
    """
    each = [_own(rows, table), _price(rows, price), _certified(rows, table)]
    return " ".join(sentence for sentence in each if sentence)


def _paid(rows: pd.DataFrame) -> list[str]:
    """Solvers with bounds but for the closed form, whose bound is its length."""
    return [solver for solver in provers(rows) if solver != EXACT]


def _own(rows: pd.DataFrame, table: pd.DataFrame) -> str:
    parts = [
        f"{row['solver']} proves {share(row['own'])} of its answers to 1e-4 or closer "
        f"(largest proven gap {digits(2)(row['gap_most'])}), in {seconds(row['wall_s'])} "
        f"(median), {seconds(row['build_s'])} of them building"
        for row in table[table["solver"].isin(_paid(rows))].to_dict("records")
    ]
    return f"By its own bound {'; '.join(parts)}." if parts else ""


def _price(rows: pd.DataFrame, price: pd.DataFrame) -> str:
    first, often = fastest(rows)
    parts = []
    for solver in _paid(rows):
        group = price[price["solver"] == solver]
        if len(group):
            items = ", ".join(
                f"{digits(2)(row['ratio'])} ({row['group']})" for row in group.to_dict("records")
            )
            parts.append(f"{solver} {items}")
    if not parts:
        return ""
    return (
        "Its price, as a multiple of the time of the fastest right answer without one "
        f"({first} on {share(often)} of the questions): {'; '.join(parts)}."
    )


def _certified(rows: pd.DataFrame, table: pd.DataFrame) -> str:
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
        text += f": all of {', '.join(full['solver'])}"
    if rest:
        items = ", ".join(
            f"{count(row['proved'])} of {count(row['attempts'])} of {row['solver']}"
            for row in plain[plain["solver"].isin(rest)].to_dict("records")
        )
        text += f"{', and' if len(full) else ':'} {items}"
    return f"{text}."


def _time_picture(table: pd.DataFrame, palette: Palette) -> Picture:
    figure = new_figure(HALF, 1.3 + 0.42 * len(table))
    plot_wall(figure.add_subplot(), table, palette)
    caption = (
        "Time of one cold attempt, building included: median (mark) and quartiles (bar). At the "
        "right: the share of answers that the solver's own bound proves to 1e-4, and that the "
        "certificate proves."
    )
    alt = "Median times and quartiles with shares of proofs, one line a solver"
    return Picture("proofs-time", caption, figure, alt, True)


def _price_picture(price: pd.DataFrame) -> Picture:
    figure = new_figure(HALF, 1.3 + 0.42 * price["solver"].nunique())
    plot_prices(figure.add_subplot(), price)
    figure.legend(loc="outside lower left", ncols=2)
    caption = (
        "Time over that of the fastest right answer without a proof, question by question: median "
        "and quartiles, right answers only. Right of 1 is slower."
    )
    return Picture("proofs-price", caption, figure, "Ratios of times by group of targets", True)


def _table(table: pd.DataFrame) -> Table:
    number = digits(2)
    columns = (
        Column("solver", "solver", kind="code"),
        Column("attempts", "attempts", count),
        Column("success", "success", share),
        *(Column(name, name, count) for name in PROOFS),
        Column("own", "own bound to 1e-4", share),
        Column("gap", "proven gap, median", number),
        Column("gap_most", "largest", number),
        Column("wall_s_q1", "time, 25 %", seconds),
        Column("wall_s", "median", seconds),
        Column("wall_s_q3", "75 %", seconds),
        Column("build_s", "building", seconds),
    )
    caption = (
        "Proved to none: the certificate's words. Own bound: attempts whose own lower bound leaves "
        "(length − bound) / length at 1e-4 or less; the closed form's bound is its length."
    )
    return Table("proofs", caption, table, columns)


def _price_table(price: pd.DataFrame) -> Table:
    number = digits(2)
    columns = (
        Column("group", "targets", kind="text"),
        Column("solver", "solver", kind="code"),
        Column("questions", "questions", count),
        Column("ratio_q1", "25 %", number),
        Column("ratio", "median", number),
        Column("ratio_q3", "75 %", number),
    )
    caption = "The ratios of the figure; questions that the solver does not answer rightly are out."
    return Table("proofs-price", caption, price, columns)
