"""The section on formulation x engine: right answers and times of every pair, by stratum too."""

from __future__ import annotations

import textwrap
from collections.abc import Collection, Hashable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap

from dubins_study.report.data.attempts import TRIAL
from dubins_study.report.data.results import Results
from dubins_study.report.data.verdicts import evaluations
from dubins_study.report.elements.columns import SOLVER, Column, columns, marks
from dubins_study.report.elements.content import (
    BENCHMARK,
    Picture,
    Place,
    Section,
    Table,
    Topic,
    picture,
)
from dubins_study.report.elements.formats import count, digits, seconds, sentences, slug, some
from dubins_study.report.elements.identity import (
    INTERVAL_TEXT,
    METHOD,
    best_first,
    percent,
    questions,
    with_share,
)
from dubins_study.report.elements.plots import HIGHEST
from dubins_study.report.elements.style import (
    BLUE,
    INK,
    MAP_PAPER,
    MUTED,
    ON_MAP,
    PAPER,
    WIDE,
    Style,
)
from dubins_study.report.statistics.compared import stratum_order
from dubins_study.report.statistics.intervals import scenario_shares
from dubins_study.report.statistics.methods import best_methods
from dubins_study.report.statistics.metrics import success
from dubins_study.report.topics.summary import best_solvers, solver_summary
from dubins_study.study.rows.manifest import MatrixEntry
from dubins_study.study.words import FORMULATIONS

# The closed form is a formulation and needs no engine: it has no place in the table.
_FORMULA = FORMULATIONS[0]
_NOT_ASKED = "it can be asked, but no row of these folders does"
_NO_KIND = "other"


class Matrix(NamedTuple):
    """The table, long and as the lines of the page.

    `cells` has a row per engine and formulation with the columns of the pair's best method, filled
    (whether there is one), few (whether it was asked less than half as many questions as others),
    reason (empty if filled) and note (its number from 1, 0 if filled). `engines` holds (kind,
    engine) in the order of lines, `formulations` the order of columns.
    """

    cells: pd.DataFrame
    engines: list[tuple[str, str]]
    formulations: list[str]
    reasons: list[str]


def matrix(methods: pd.DataFrame, entries: Sequence[MatrixEntry]) -> Matrix:
    """Every formulation with every engine; without entries, only the pairs that have rows."""
    asked = methods[(methods["formulation"] != _FORMULA) & (methods["right_of"] > 0)]
    best = best_methods(asked, ["engine", "formulation"]).assign(filled=True)
    known = [entry for entry in entries if entry.formulation != _FORMULA]
    with_rows = set(best["engine"])
    readable = {entry.engine for entry in known if entry.kind != "exact"} | with_rows
    known = [entry for entry in known if entry.engine in readable]
    engines = _engines(known, best)
    given = {*best["formulation"], *(entry.formulation for entry in known)}
    formulations = [name for name in FORMULATIONS if name in given]
    formulations += sorted(given - set(formulations))
    why = {(e.engine, e.formulation): e.reason or _NOT_ASKED for e in known}
    pairs = pd.DataFrame(
        [
            (kind, engine, formulation, why.get((engine, formulation), ""))
            for kind, engine in engines
            for formulation in formulations
        ],
        columns=["kind", "engine", "formulation", "reason"],
    )
    cells = pairs.merge(best, on=["engine", "formulation"], how="left")
    cells["filled"] = cells["filled"].eq(True)
    cells["few"] = cells["right_of"] < asked["right_of"].max() / 2
    cells["reason"] = cells["reason"].where(~cells["filled"], "")
    reasons = list(dict.fromkeys(reason for reason in cells["reason"] if reason))
    number = {reason: place for place, reason in enumerate(reasons, 1)}
    cells["note"] = cells["reason"].map(number).fillna(0).astype(int)
    return Matrix(cells, engines, formulations, reasons)


def _engines(entries: Sequence[MatrixEntry], best: pd.DataFrame) -> list[tuple[str, str]]:
    """(kind, engine) by kind in the order of entries; engines that no entry names last."""
    kind_of: dict[str, str] = {}
    for entry in entries:
        kind_of.setdefault(entry.engine, entry.kind or _NO_KIND)
    for engine in sorted(set(best["engine"]), key=str.casefold):
        kind_of.setdefault(engine, _NO_KIND if entries else "")
    kinds = list(dict.fromkeys(kind_of.values()))
    order = sorted(kind_of, key=lambda engine: kinds.index(kind_of[engine]))
    return [(kind_of[engine], engine) for engine in order]


def strata(rows: pd.DataFrame) -> pd.DataFrame:
    """The share of right answers of each solver in each stratum, where a path exists."""
    kept = rows[rows["answerable"]]
    kept = kept.assign(right=success(kept), stratum=kept["label"].fillna(""))
    shares = scenario_shares(kept, by=["solver", "stratum"], success="right", scenario=TRIAL)
    frame = shares.reset_index()
    return with_share(frame[["solver", "stratum"]], "right", frame["successes"], frame["trials"])


def strata_blocks(
    results: Results, methods: pd.DataFrame, shares: pd.DataFrame, best: Collection[str]
) -> list[Picture | Table]:
    """The shares of `strata` as maps and as a table; nothing if there is one stratum."""
    names = stratum_order(results, shares["stratum"])
    if len(names) < 2:
        return []
    methods = methods.assign(few=methods["right_of"] < methods["right_of"].max() / 2)
    wide = shares.pivot(index="solver", columns="stratum", values="right_share")[names]
    pictures = [
        _stratum_picture(str(formulation), group, wide, first=place == 0)
        for place, (formulation, group) in enumerate(methods.groupby("formulation", sort=False))
        if formulation != "closed form"
    ]
    table = _stratum_table(methods, shares, names)
    return [*pictures, *best_first(table, table.frame["solver"], best)]


def _stratum_picture(
    formulation: str, methods: pd.DataFrame, wide: pd.DataFrame, *, first: bool
) -> Picture:
    few = methods["few"].any()
    shares = wide.reindex(methods["solver"]).set_axis(_names(methods), axis=0)
    return picture(
        f"strata-{slug(formulation)}",
        plot_strata,
        shares,
        caption=f"{formulation[0].upper()}{formulation[1:]}: percent right in each stratum."
        f"{' A star: asked less than half as many questions.' if few else ''}",
        alt=f"Map of right answers of {formulation}, methods by strata",
        height=1.35 + 0.145 * len(shares),
    )


def _names(methods: pd.DataFrame) -> list[str]:
    """Engines, with what else tells the methods of a formulation apart: short, for small maps."""
    several = len(set(methods["guess"]) - {"none"}) > 1
    names = []
    for row in methods.to_dict("records"):
        guess = row["guess"] if several and row["guess"] != "none" else ""
        settings = row["settings"].replace("presolve", "presolved")
        star = " *" if row["few"] else ""
        names.append(", ".join(filter(None, (row["engine"], guess, settings))) + star)
    return names


def _stratum_table(methods: pd.DataFrame, shares: pd.DataFrame, names: list[str]) -> Table:
    texts = shares.assign(
        text=[
            f"{whole_percent(value)} %\n{whole_percent(low)}–{whole_percent(high)}"
            for value, low, high in zip(
                shares["right_share"], shares["right_low"], shares["right_high"], strict=True
            )
        ]
    ).pivot(index="solver", columns="stratum", values="text")
    frame = methods[["formulation", "engine", "guess", "settings", "solver"]].merge(
        texts.reset_index(), on="solver"
    )
    frame["guess"] = [
        ", ".join(filter(None, pair))
        for pair in zip(frame["guess"], frame["settings"], strict=True)
    ]
    shown = (
        *columns(kind="text", formulation="formulation", engine="engine"),
        *columns(kind="text", guess="guess and settings"),
        *(Column(name, name, kind="cell") for name in names),
    )
    caption = (
        "Questions answered right, stratum by stratum, with the 95 % interval (Wilson, a trial a "
        "question)."
    )
    return Table("strata", caption, frame, shown, numbers=("solver",), dense=True)


# One hue from light to dark, so that the order stays visible in grey print.
DEPTH = LinearSegmentedColormap.from_list("depth", ["#f4f7fa", "#9cc6e0", BLUE, "#0b2f47"])
# From this share on, a cell is so dark that its number is written in white.
_DARK = 0.5


def plot_share_map(
    ax: Axes, shares: pd.DataFrame, notes: pd.DataFrame | None = None, size: float = 7.0
) -> None:
    """Draw a table of shares as a map; each cell has its share in percent, an empty one is NaN.

    Notes are the texts of the empty cells, and what follows the number in the others. The letters
    have a size in points.
    """
    values = shares.to_numpy(dtype=np.float64)
    lines, columns = values.shape
    flat: Style = {"interpolation": "nearest", "aspect": "auto"}
    ax.imshow(np.ma.masked_invalid(values), cmap=DEPTH, vmin=0, vmax=1, **flat)
    gaps: Style = {"colors": PAPER, "linewidth": 1.2}
    ax.hlines(np.arange(1, lines) - 0.5, -0.5, columns - 0.5, **gaps)
    ax.vlines(np.arange(1, columns) - 0.5, -0.5, lines - 0.5, **gaps)
    for i, j in np.ndindex(lines, columns):
        text, ink = "" if notes is None else str(notes.iat[i, j]), MUTED
        if np.isfinite(values[i, j]):
            text = whole_percent(float(values[i, j])) + text
            ink = MAP_PAPER if values[i, j] > _DARK else ON_MAP
        if text:
            # the layout need not measure what lies inside the axes
            ax.text(
                *(j, i, text), ha="center", va="center", fontsize=size, color=ink, in_layout=False
            )
    ax.set_yticks(range(lines), shares.index, color=INK, fontsize=size)
    ax.set_xticks(range(columns), shares.columns, color=INK, fontsize=size)
    ax.tick_params(length=0)
    ax.grid(False)
    for spine in ax.spines.values():
        spine.set_visible(False)


def whole_percent(share: float) -> str:
    """A share in whole percent, 100 only for 1 and 0 only for 0."""
    if share in (0, 1):
        return f"{100 * share:.0f}"
    return f"{min(max(100 * share, 1), 99):.0f}"


def _drawn_engines(table: Matrix) -> list[tuple[str, str]]:
    """(kind, engine) of the lines of the figure: engines that have rows with any formulation."""
    asked = set(table.cells.loc[table.cells["filled"], "engine"])
    return [pair for pair in table.engines if pair[1] in asked]


def plot_matrix(ax: Axes, table: Matrix) -> None:
    """Shares of right answers, engines by formulations; a pair without rows stays empty.

    A star follows the share of a method that was asked fewer questions than others.
    """
    names = [engine for _, engine in _drawn_engines(table)]
    stars = table.cells["few"].map({True: "*", False: ""})
    cells = table.cells.assign(text=stars.where(table.cells["filled"], ""))
    wide = {
        key: cells.pivot(index="engine", columns="formulation", values=key).reindex(
            index=names, columns=table.formulations
        )
        for key in ("right_share", "text")
    }
    plot_share_map(ax, wide["right_share"], wide["text"])
    # Aslant, since a name is wider than its column.
    aslant: Style = {"rotation": 30, "ha": "left", "rotation_mode": "anchor", "fontsize": 7}
    ax.set_xticks(range(len(table.formulations)), table.formulations, **aslant)
    ax.xaxis.tick_top()
    # The kinds of engines stand at the right, with a line between two kinds.
    kinds = [kind for kind, _ in _drawn_engines(table)]
    starts = [place for place, kind in enumerate(kinds) if place == 0 or kind != kinds[place - 1]]
    for start in starts:
        right, name = len(table.formulations) - 0.4, textwrap.fill(kinds[start], 11)
        ax.text(right, start - 0.4, name, va="top", fontsize=6, color=MUTED)
        if start:
            ax.axhline(start - 0.5, color=INK, linewidth=0.6)


def plot_strata(ax: Axes, shares: pd.DataFrame) -> None:
    """Shares of right answers of one formulation: methods by strata."""
    plot_share_map(ax, shares, size=6)
    ax.set_xticks(range(len(shares.columns)), shares.columns, rotation=90, fontsize=6)


def matrix_section(results: Results) -> Section | None:
    """Formulation x engine as a picture and two tables; the shares by stratum."""
    attempts = results.attempts
    methods = solver_summary(attempts).merge(evaluations(attempts), on="solver", how="left")
    methods = methods[methods["right_of"] > 0].reset_index(drop=True)
    entries = [entry for run in results.folders for entry in run.manifest.matrix]
    table = matrix(methods, entries)
    if not table.cells["filled"].any():
        return None
    blocks: list[Picture | Table] = [_picture(table), _table(table)]
    if table.reasons:
        blocks.append(_reasons(table))
    best = best_solvers(results)
    blocks += best_first(_methods(methods), methods["solver"], best)
    blocks += strata_blocks(results, methods, strata(results.rows), best)
    lead = (
        "Read along a line for what the formulation buys, down a column for what the engine buys."
    )
    return Section("matrix", "Formulation by engine", _text(table), tuple(blocks), lead)


def _text(table: Matrix) -> str:
    filled = table.cells[table.cells["filled"]]
    spanned = filled[~filled["few"]]
    spans = [_span(spanned, key) for key in ("formulation", "engine")]
    return sentences(
        "A result belongs to a formulation, an engine and an initial guess.",
        f"Of {some(len(table.cells), 'pair')} ({count(len(table.engines))} engines, "
        f"{count(len(table.formulations))} formulations) {count(len(filled))} have rows; the "
        "others have a reason."
        if table.reasons
        else f"{some(len(filled), 'pair')} of {some(len(table.engines), 'engine')} and "
        f"{some(len(table.formulations), 'formulation')} have rows.",
        *filter(None, spans),
    )


def _span(filled: pd.DataFrame, key: str) -> str:
    """The formulation, or the engine, whose best guesses differ most across the other."""
    other = "engine" if key == "formulation" else "formulation"
    groups = filled.groupby(key, sort=False)["right_share"]
    spans = (groups.max() - groups.min())[groups.size() > 1]
    if spans.empty or not spans.max() > 0:
        return ""
    name = spans.idxmax()
    pairs = filled[filled[key] == name].sort_values("right_share", kind="stable")
    low, high = pairs.iloc[0], pairs.iloc[-1]
    return (
        f"Over {other}s, {name} differs most: from {percent(low['right_share'])} % right "
        f"({low[other]}) to {percent(high['right_share'])} % ({high[other]})."
    )


def _picture(table: Matrix) -> Picture:
    star = " A star: asked less than half as many questions." if table.cells["few"].any() else ""
    return picture(
        "matrix",
        plot_matrix,
        table,
        caption="Percent of the questions with a path that are answered right, with the best of "
        "the pair's initial guesses and settings. Empty: the pair has no row; the table of reasons "
        f"says why.{star}",
        alt="Map of right answers, engines by formulations",
        height=min(HIGHEST, 0.75 + 0.175 * max(len(_drawn_engines(table)), 5)),
        width=WIDE,
    )


def _cell(row: Mapping[Hashable, Any]) -> str:
    if not row["filled"]:
        return f"[{row['note']}]" if row["note"] else ""
    low, high = percent(row["right_low"]), percent(row["right_high"])
    milliseconds = digits(3)(1e3 * row["wall_s"])
    few = f"\nof {questions(row['right_of'])}" if row["few"] else ""
    return f"{percent(row['right_share'])} %\n{low}–{high}\n{milliseconds} ms{few}"


def _table(table: Matrix) -> Table:
    cells = table.cells.assign(text=[_cell(row) for row in table.cells.to_dict("records")])
    wide = cells.pivot(index="engine", columns="formulation", values="text")
    wide = wide.reindex([engine for _, engine in table.engines]).reset_index()
    wide["kind"] = [kind for kind, _ in table.engines]
    wide["named"] = [f"{engine} ({kind})" if kind else engine for kind, engine in table.engines]
    shown = (
        *columns(kind="text", named="engine"),
        *(Column(name, name, kind="cell") for name in table.formulations),
    )
    empty = {
        (line, name): "note"
        for line, (_, engine) in enumerate(table.engines)
        for name in cells.loc[(cells["engine"] == engine) & ~cells["filled"], "formulation"]
    }
    caption = (
        "Every formulation with every engine: questions with a path that are answered right, the "
        "95 % interval (Wilson, a trial a question), and the median time of an attempt, failures "
        "included; with the guess and settings that are most surely right, which the table of all "
        "methods names. Chosen after the fact, the best of several guesses flatters a little. The "
        "number of questions stands where it is less than half that of others. A number in "
        "brackets is the reason why a pair has no row."
    )
    return Table("matrix", caption, wide, shown, empty, ("engine", "kind"), dense=True)


def _reasons(table: Matrix) -> Table:
    pairs = table.cells["note"].value_counts()
    frame = pd.DataFrame(
        {
            "note": [f"[{number}]" for number in range(1, len(table.reasons) + 1)],
            "reason": table.reasons,
            "pairs": [int(pairs[number]) for number in range(1, len(table.reasons) + 1)],
        }
    )
    shown = (
        *columns(kind="text", note="number"),
        *columns(kind="prose", reason="why the pair has no row"),
        *columns(count, pairs="pairs"),
    )
    return Table("matrix-reasons", "Reasons for pairs without rows.", frame, shown)


def _methods(methods: pd.DataFrame) -> Table:
    shown = (
        *METHOD[:-1],
        SOLVER,
        *columns(kind="cell", right_text="right of n, 95 %"),
        *columns(count, wrong_basins="wrong basins", false_claims="false claims"),
        *columns(seconds, wall_s="median time"),
        *columns(digits(3), evaluations="evaluations, median"),
    )
    caption = (
        f"Questions that have a path. {INTERVAL_TEXT} Wrong basins and false claims "
        "count attempts. A dash: the engine does not count its evaluations."
    )
    numbers = ("attempts", "right_of", "right_share", "right_low", "right_high", "settings")
    return Table("methods", caption, methods, shown, marks(methods, "false_claims"), numbers)


TOPIC = Topic("formulation by engine", matrix_section, BENCHMARK, place=Place.FRONT)
