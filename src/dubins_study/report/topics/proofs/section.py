"""The section on what a proof costs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

import pandas as pd

from dubins_study.report.data.attempts import EXACT, PROOFS
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, Column, columns
from dubins_study.report.elements.content import Picture, Section, Table, picture
from dubins_study.report.elements.formats import count, digits, seconds, sentences, share
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.style import WIDE
from dubins_study.report.elements.topic import Topic
from dubins_study.report.statistics.metrics import solver_order
from dubins_study.report.topics.proofs.figures import plot_prices, plot_wall
from dubins_study.report.topics.proofs.numbers import fastest, prices, proofs, provers

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
    blocks.append(_table(table))
    if len(price):
        blocks.append(_price_table(price))
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
        "right: the share of answers that the solver's own bound proves to 1e-4, and that the "
        "certificate proves."
    )
    alt = "Median times and quartiles with shares of proofs, one line per solver"
    height = min(0.9 + 0.25 * len(table), 6.5)
    return picture(
        "proofs-time",
        plot_wall,
        table,
        palette,
        caption=caption,
        alt=alt,
        height=height,
        width=WIDE,
    )


def _price_picture(price: pd.DataFrame, palette: Palette) -> Picture:
    caption = (
        "Time over that of the fastest right answer without a proof, question by question: median "
        "and quartiles, right answers only. Right of 1 is slower."
    )
    alt, height = (
        "Ratios of times by group of targets",
        min(1.1 + 0.25 * price["solver"].nunique(), 6.5),
    )
    data = price, palette
    return picture(
        "proofs-price", plot_prices, *data, caption=caption, alt=alt, height=height, width=WIDE
    )


def _table(table: pd.DataFrame) -> Table:
    number = digits(2)
    shown = (
        SOLVER,
        *columns(count, attempts="attempts"),
        *columns(share, success="success"),
        *(Column(name, name, count) for name in PROOFS),
        *columns(share, own_bound="own bound to 1e-4"),
        *columns(number, gap="proven gap, median", gap_most="largest"),
        *columns(
            seconds, wall_s_q1="time, 25 %", wall_s="median", wall_s_q3="75 %", build_s="building"
        ),
    )
    caption = (
        "Proved to none: the certificate's words. Own bound: attempts whose own lower bound leaves "
        "(length − bound) / length at 1e-4 or less; the closed form's bound is its length."
    )
    return Table("proofs", caption, table, shown, dense=True)


def _price_table(price: pd.DataFrame) -> Table:
    number = digits(2)
    shown = (
        *columns(kind="text", group="targets"),
        SOLVER,
        *columns(count, questions="questions"),
        *columns(number, ratio_q1="25 %", ratio="median", ratio_q3="75 %"),
    )
    caption = "The ratios of the figure; only questions that the solver answers correctly."
    return Table("proofs-price", caption, price, shown)


TOPIC = Topic("what a proof costs", proofs_section, "proofs")
