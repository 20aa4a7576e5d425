"""The section on what a proof costs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.data.attempts import EXACT, PROOFS
from dubins_study.report.data.results import Results
from dubins_study.report.elements.axes import duration, log_axis, mark_limit
from dubins_study.report.elements.columns import SOLVER, Column, columns
from dubins_study.report.elements.content import Picture, Section, Table, picture
from dubins_study.report.elements.formats import count, digits, seconds, sentences, share
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.panels import label_lines, plot_quartiles
from dubins_study.report.elements.style import BLUE, GREEN, MUTED, VERMILION, WIDE, Style
from dubins_study.report.elements.topic import Topic
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


_GROUPS = ((BLUE, "o"), (VERMILION, "s"), (GREEN, "^"))


def plot_wall(ax: Axes, table: pd.DataFrame, palette: Palette) -> None:
    """Draw median and quartiles of the total time; write the share of proven answers next to it.

    Columns solver, wall_s, wall_s_q1, wall_s_q3 (s), own_bound (share), proved and attempts
    (counts).
    """
    places = np.arange(len(table))[::-1]
    looks = palette.looks(table["solver"])
    beside: dict[str, Any] = {"fontsize": 7.5, "color": MUTED}
    for place, row in zip(places, table.to_dict("records"), strict=True):
        shares = f"{_percent(row['own_bound'])}, {_percent(row['proved'] / row['attempts'])}"
        across = ax.get_yaxis_transform()
        ax.text(1.01, place, shares, transform=across, va="center", **beside)
        if row["wall_s"] > 0:
            plot_quartiles(ax, row, "wall_s", place, looks[row["solver"]])
    heading = "own bound, certificate"
    ax.text(1.01, 1.0, heading, transform=ax.transAxes, va="bottom", **beside)
    ax.set(xscale="log", xlabel="time of one attempt")
    log_axis(ax.xaxis, duration)
    label_lines(ax, palette.names(table["solver"]).values(), places)


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"


def plot_prices(ax: Axes, table: pd.DataFrame, palette: Palette) -> None:
    """Ratio of times by group, median and quartiles.

    Columns group, solver, ratio, ratio_q1, ratio_q3; `palette` names the solvers.
    """
    solvers = solver_order(table["solver"].tolist())[::-1]
    names = list(dict.fromkeys(table["group"]))
    for number, name in enumerate(names):
        colour, marker = _GROUPS[number % len(_GROUPS)]
        group = table[table["group"] == name].set_index("solver")
        lift = 0.22 * ((len(names) - 1) / 2 - number)
        places = np.array([solvers.index(solver) for solver in group.index]) + lift
        bar: Style = {"color": colour, "linewidth": 2, "alpha": 0.45}
        ax.hlines(places, group["ratio_q1"], group["ratio_q3"], **bar)
        ax.plot(group["ratio"], places, linestyle="none", marker=marker, color=colour, label=name)
    mark_limit(ax, 1.0)
    ax.set(xscale="log", xlabel="time / fastest right answer without a proof")
    log_axis(ax.xaxis)
    label_lines(ax, palette.names(solvers).values(), range(len(solvers)))
    figure = ax.figure
    figure.legend(loc="outside lower left", ncols=3)


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
