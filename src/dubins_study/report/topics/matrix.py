"""The section on formulation by engine.

It has the share right of every pair, and the shares by stratum.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from itertools import chain

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from dubins_study.report.data.attempts import TRIAL, own_name
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import Column, columns
from dubins_study.report.elements.content import (
    BENCHMARK,
    Block,
    Picture,
    Section,
    Table,
    Topic,
    panels_picture,
)
from dubins_study.report.elements.formats import count, some
from dubins_study.report.elements.identity import (
    percent,
)
from dubins_study.report.elements.plots import HIGHEST
from dubins_study.report.elements.style import (
    BLUE,
    HALF,
    INK,
    MAP_PAPER,
    MUTED,
    ON_MAP,
    PAPER,
    WIDE,
    new_figure,
)
from dubins_study.report.statistics.intervals import scenario_shares
from dubins_study.report.statistics.methods import best_methods, stratum_order
from dubins_study.report.statistics.metrics import success
from dubins_study.report.topics.summary import solver_summary
from dubins_study.study.rows.manifest import MatrixEntry
from dubins_study.study.words import FORMULATIONS

# The closed form is a formulation and needs no engine: it has no place in the table.
_FORMULA = FORMULATIONS[0]
_NOT_ASKED = "possible, but no row of these folders has it"
_NO_KIND = "other"


def matrix(methods: pd.DataFrame, entries: Sequence[MatrixEntry]) -> pd.DataFrame:
    """A frame with every formulation and every engine.

    `methods` is the frame of `solver_summary`. `entries` are the pairs that the manifests name;
    without them only pairs that have rows are there. A row is an engine with a formulation, in the
    order of lines and columns. Columns: kind (of the engine); those of the pair's best method;
    filled (whether there is one); few (whether it was asked less than half as many questions as
    others); reason (why the pair has no rows; empty if filled); note (the reason's number from 1; 0
    if filled).
    """
    engines = methods[(methods["formulation"] != _FORMULA) & (methods["right_of"] > 0)]
    most = engines.groupby(["engine", "formulation"])["right_of"].transform("max")
    whole = engines[2 * engines["right_of"] > most]  # without methods asked a sample only
    best = best_methods(whole, ["engine", "formulation"]).assign(filled=True)
    usable = [entry for entry in entries if entry.formulation != _FORMULA]
    # An engine of the kind `exact` has a line only if it has rows.
    with_rows = set(best["engine"])
    readable = {entry.engine for entry in usable if entry.kind != "exact"} | with_rows
    usable = [entry for entry in usable if entry.engine in readable]
    names = {*best["formulation"], *(entry.formulation for entry in usable)}
    formulations = [name for name in FORMULATIONS if name in names]
    formulations += sorted(names - set(formulations))
    reasons = {(entry.engine, entry.formulation): entry.reason or _NOT_ASKED for entry in usable}
    lines: list[tuple[str, ...]] = []
    for kind, engine in _engines(usable, best):
        lines += [(kind, engine, name, reasons.get((engine, name), "")) for name in formulations]
    pairs = pd.DataFrame(lines, columns=["kind", "engine", "formulation", "reason"])
    cells = pairs.merge(best, on=["engine", "formulation"], how="left")
    cells["filled"] = cells["filled"].eq(True)
    cells["few"] = cells["right_of"] < engines["right_of"].max() / 2
    cells["reason"] = cells["reason"].where(~cells["filled"], "")
    cells["note"] = pd.factorize(cells["reason"].where(cells["reason"] != ""))[0] + 1
    return cells


def _engines(entries: Sequence[MatrixEntry], best: pd.DataFrame) -> list[tuple[str, str]]:
    """Pairs (kind, engine) in the map's order.

    Plug-ins come first. Then the kinds follow in the order of the entries. Engines that no entry
    names come last.
    """
    kind_of: dict[str, str] = {}
    for entry in entries:
        kind_of.setdefault(entry.engine, entry.kind or _NO_KIND)
    no_kind = ""
    if entries:
        no_kind = _NO_KIND
    for engine in sorted(set(best["engine"]), key=str.casefold):
        kind_of.setdefault(engine, no_kind)
    plugin_kinds = dict.fromkeys(best.loc[best["solver"].map(own_name) != "", "engine"], "plug-in")
    kind_of = plugin_kinds | kind_of | plugin_kinds  # they come first, whatever an entry says
    kinds = list(dict.fromkeys(kind_of.values()))
    order = sorted(kind_of, key=lambda engine: kinds.index(kind_of[engine]))
    return [(kind_of[engine], engine) for engine in order]


def strata(rows: pd.DataFrame) -> pd.DataFrame:
    """The share right of each solver in each stratum.

    Only questions that have a path count. Columns: solver, stratum, and those of `scenario_shares`.
    """
    answerable = rows[rows["answerable"]]
    answerable = answerable.assign(
        right=success(answerable), stratum=answerable["label"].fillna("")
    )
    shares = scenario_shares(answerable, by=["solver", "stratum"], success="right", scenario=TRIAL)
    return shares.reset_index()


def _stratum_table(results: Results, methods: pd.DataFrame, shares: pd.DataFrame) -> Table | None:
    """The table of shares by stratum, or None.

    It has a line per method. `shares` is the frame of `strata`. None if there is only one stratum.
    """
    names = stratum_order(results, shares["stratum"])
    if len(names) < 2:
        return None
    texts = [
        f"{percent(value, 0)} %\n{percent(low, 0)}–{percent(high, 0)}"
        for value, low, high in shares[["share", "low", "high"]].to_numpy()
    ]
    wide = shares.assign(text=texts).pivot(index="solver", columns="stratum", values="text")
    method_names = methods[["formulation", "engine", "guess", "settings", "solver"]]
    frame = method_names.merge(wide.reset_index(), on="solver")
    pairs = zip(frame["guess"], frame["settings"], strict=True)
    frame["guess"] = [", ".join(filter(None, pair)) for pair in pairs]
    shown = (
        *columns(kind="text", formulation="formulation", engine="engine"),
        *columns(kind="text", guess="guess and settings"),
        *(Column(name, name, kind="cell") for name in names),
    )
    caption = (
        "Share of questions answered right, stratum by stratum, with its 95 % interval (Wilson; "
        "one trial per question)."
    )
    return Table("strata", caption, frame, shown, numbers=("solver",), dense=True)


# One hue from light to dark, so that the order stays visible in grey print.
DEPTH = LinearSegmentedColormap.from_list("depth", ["#f4f7fa", "#9cc6e0", BLUE, "#0b2f47"])
# From this share on, a cell is so dark that its number is written in white.
_DARK = 0.5


def plot_matrix(ax: Axes, cells: pd.DataFrame, size: float) -> None:
    """Draw a map of shares right, engines by formulations.

    `cells` is the frame of `matrix`. Shares are in percent, and `size` is that of the letters (pt).
    A star follows the share of a method that was asked fewer questions than others. A pair without
    rows has the number of its reason.
    """
    engines = cells.drop_duplicates("engine")
    names = cells["formulation"].unique().tolist()
    lines = len(engines)
    across = len(names)
    # by engine, then by formulation
    shares = cells["right_share"].to_numpy(dtype=np.float64).reshape(lines, across)
    ax.pcolormesh(
        range(across),
        range(lines),
        np.ma.masked_invalid(shares),
        cmap=DEPTH,
        vmin=0,
        vmax=1,
        edgecolors=PAPER,
        linewidth=1.2,
    )
    ax.invert_yaxis()
    for place, cell in enumerate(cells.to_dict("records")):
        text = ""
        ink = MUTED
        if cell["note"]:
            text = f"[{cell['note']}]"
        if cell["filled"]:
            text = percent(cell["right_share"], 0)
            ink = ON_MAP
            if cell["right_share"] > _DARK:
                ink = MAP_PAPER
            if cell["few"]:
                text += "*"
        ax.text(
            place % across,
            place // across,
            text,
            ha="center",
            va="center",
            fontsize=size,
            color=ink,
            in_layout=False,  # the layout need not measure what lies inside the axes
        )
    ax.set_yticks(range(lines), engines["engine"], color=INK, fontsize=7)
    ax.set_xticks(
        range(across),
        names,
        rotation=40,  # since a name is wider than its column
        rotation_mode="anchor",
        ha="left",
        color=INK,
        fontsize=size,
    )
    ax.xaxis.tick_top()
    ax.tick_params(length=0)
    ax.grid(False)
    for spine in ax.spines.values():
        spine.set_visible(False)
    # The kinds of engines stand at the right, with a line between two kinds.
    kinds = engines["kind"].tolist()
    for start in (kinds.index(kind) for kind in dict.fromkeys(kinds)):
        name = textwrap.fill(kinds[start], 11)
        ax.text(across - 0.4, start - 0.4, name, va="top", fontsize=6, color=MUTED)
        if start:
            ax.axhline(start - 0.5, color=INK, linewidth=0.6)


def matrix_section(results: Results) -> Section | None:
    """The section on formulation by engine.

    It has the map, the reasons why pairs have no row, and the shares by stratum.
    """
    methods = solver_summary(results.attempts)
    methods = methods[methods["right_of"] > 0].reset_index(drop=True)
    entries = chain.from_iterable(run.manifest.matrix for run in results.folders)
    cells = matrix(methods, list(entries))
    if not cells["filled"].any():
        return None
    blocks: list[Block] = [_picture(cells)]
    if cells["note"].any():
        blocks.append(_reasons(cells))
    strata_table = _stratum_table(results, methods, strata(results.rows))
    if strata_table is not None:
        blocks.append(strata_table)
    lead = "Along a line the formulation changes, down a column the engine: see which matters more."
    return Section("matrix", "Formulation by engine", _text(cells), tuple(blocks), lead)


def _text(cells: pd.DataFrame) -> str:
    engines = cells["engine"].nunique()
    formulations = cells["formulation"].nunique()
    filled = cells[cells["filled"]]
    numbers = (
        f"{some(len(filled), 'pair')} of {some(engines, 'engine')} and "
        f"{some(formulations, 'formulation')} have rows."
    )
    if cells["note"].any():
        numbers = (
            f"Of {some(len(cells), 'pair')} ({count(engines)} engines, {count(formulations)} "
            f"formulations) {count(len(filled))} have rows; the others have a reason."
        )
    return f"A result belongs to a formulation, an engine and an initial guess. {numbers}"


def _picture(cells: pd.DataFrame) -> Picture:
    star = ""
    if cells["few"].any():
        star = " A star: asked less than half as many questions."
    reasons = ""
    if cells["note"].any():
        reasons = " In brackets: why the pair has no row."
    caption = (
        "Percent of the questions with a path answered right, with the pair's best initial guess "
        "and settings. The choice was made after the runs, so the shares are slightly too high."
        f"{star}{reasons}"
    )
    alt = "Map of right answers, engines by formulations"
    high = 0.75 + 0.175 * max(cells["engine"].nunique(), 5)
    return panels_picture("matrix", caption, _figure, alt, cells, min(HIGHEST, high))


def _figure(cells: pd.DataFrame, height: float, *, narrow: bool) -> Figure:
    width = WIDE
    letters = 6.5
    if narrow:
        width = HALF
        letters = 4.8
    figure = new_figure(width, height)
    plot_matrix(figure.add_subplot(), cells, letters)
    return figure


def _reasons(cells: pd.DataFrame) -> Table:
    """The table of the numbered reasons."""
    noted = cells[cells["note"] > 0].groupby("note")["reason"]
    frame = noted.agg(reason="first", pairs="size").reset_index()
    frame["note"] = [f"[{number}]" for number in frame["note"]]
    shown = (
        *columns(kind="text", note="number"),
        *columns(kind="prose", reason="why the pair has no row"),
        *columns(count, pairs="pairs"),
    )
    return Table("matrix-reasons", "Reasons for pairs without rows.", frame, shown)


TOPIC = Topic("formulation by engine", matrix_section, BENCHMARK)
