"""Two sections on sweeps of the radius.

One has the length and word against the radius, the other the time that a warm start saves.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.data.attempts import EXACT, SUCCESSES
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, columns
from dubins_study.report.elements.content import General, Picture, Section, Table, Topic, picture
from dubins_study.report.elements.formats import count, digits, seconds, share
from dubins_study.report.elements.looks import LINES, Palette, in_page_order
from dubins_study.report.elements.style import (
    INK,
    MUTED,
    mark_limit,
    plain_log_axis,
)
from dubins_study.report.statistics.metrics import (
    circle_radius,
    success,
)
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.scenario_frame import scenario_of

_FEWEST_RADII = 4  # fewer do not show a curve
_QUESTION = ["solver", "experiment", "scenario_id", "branch"]
_PLACE = ["x", "y", "heading", "target_x", "target_y"]
VISIBLE = 0.01  # relative; an answer that is less too long lies on the line of the shortest
_VISIBLE = f"{100 * VISIBLE:g} %"
_MOST_LETTERS = 34  # of a solver's name in the figure
_WORD_SHADE = {"LS": 0.06, "RS": 0.12, "RL": 0.22, "LR": 0.3}
_WORD_LINE = {"LS": LINES[1], "RS": LINES[2]}  # of the paper's two words

WARM_COLUMNS = (
    SOLVER,
    *columns(count, questions="questions"),
    *columns(seconds, cold_s="cold, median", warm_s="warm, median"),
    *columns(digits(3), ratio="warm / cold", work="iterations, warm / cold"),
    *columns(share, cold_success="success cold", warm_success="success warm"),
)


def sweep_rows(rows: pd.DataFrame) -> dict[tuple[str, str], pd.DataFrame]:
    """The rows of each sweep: (experiment, label) -> rows.

    A sweep is a label with one start and one target at `_FEWEST_RADII` radii or more.
    """
    best = rows[rows["branch"] == "best"]
    sweeps = {}
    for (experiment, label), group in best.groupby(["experiment", "label"]):
        radii = group.loc[group["reference_word"].notna(), "radius"].nunique()
        if radii >= _FEWEST_RADII and len(group[_PLACE].drop_duplicates()) == 1:
            sweeps[str(experiment), str(label)] = group
    return sweeps


def shortest_lengths(rows: pd.DataFrame) -> pd.DataFrame:
    """The shortest length at each radius of a sweep.

    A row per radius, in rising order. The column `length` is the closed form's length, or else the
    reference.
    """
    judged = rows[rows["reference_word"].notna()].sort_values("radius").drop_duplicates("radius")
    exact = rows[rows["solver"] == EXACT].drop_duplicates("radius").set_index("radius")["length"]
    return judged.assign(
        length=judged["radius"].map(exact).fillna(judged["reference"]).astype(float)
    )


def visibly_wrong(rows: pd.DataFrame) -> pd.DataFrame:
    """The answers visibly longer, or without arrival.

    In the figure they do not lie on the line of the shortest lengths.
    """
    return rows[~rows["verdict"].isin(SUCCESSES) & ~(rows["gap"] <= VISIBLE)]


def _place(rows: pd.DataFrame) -> dict[str, float]:
    """The start and the target of one sweep."""
    return {key: float(rows[key].iloc[0]) for key in _PLACE}


def radius_section(results: Results) -> Section | None:
    """The section with one figure per sweep."""
    sweeps = sweep_rows(results.rows)
    if not sweeps:
        return None
    palette = Palette.of_page(results)
    blocks: list[Picture] = []
    for number, ((_, label), group) in enumerate(sweeps.items(), start=1):
        # The radius at which a turning circle passes through the target; else infinite.
        circle = circle_radius(**_place(group))
        blocks.append(
            picture(
                f"radius-{number}",
                _draw_sweep,
                group,
                circle,
                palette,
                caption=f"{label[:1].upper()}{label[1:]}. Length units; R* = {digits(5)(circle)}.",
                alt=f"Length over radius, {label}",
                height=2.9,
            )
        )
    text = (
        "At R* = r² / (2 |Y|) a turning circle passes through the target (r is its distance, Y its "
        "offset to the left of the start heading). Beyond R* the target lies inside the circle and "
        "the word changes. The length jumps if the target was on the circle's front half. Heavy: "
        "the shortest length, with its word at the top. Grey: LS (dashed) and RS (dotted), where "
        f"they exist. Open marks: answers more than {_VISIBLE} longer. Crosses at the foot: "
        "answers that do not arrive."
    )
    lead = (
        "At R* the target enters a turning circle. See there how the word changes, and how the "
        "length jumps if the target was ahead."
    )
    return Section("radius", "Length and word against radius", text, tuple(blocks), lead)


def _draw_sweep(ax: Axes, rows: pd.DataFrame, circle: float, palette: Palette) -> None:
    """Draw one sweep on the axes.

    There are the shortest length over the radius, its words, the radius R* (`circle`), and every
    answer that is visibly wrong.
    """
    references = shortest_lengths(rows)
    wrong = visibly_wrong(rows)
    _draw_shortest(ax, references)
    _draw_words(ax, _place(rows), references["radius"])
    _draw_wrong(ax, wrong, palette)
    smallest = references["radius"].min()
    largest = references["radius"].max()
    if smallest < circle < largest:
        mark_limit(ax, circle)
        ax.text(
            circle,
            1.02,
            f"R* = {digits(4)(circle)}",
            transform=ax.get_xaxis_transform(),
            ha="center",
            fontsize=8,
            color=MUTED,
        )
    ax.set(xscale="log", xlim=(smallest, largest), xlabel="turning radius R", ylabel="length")
    foot = references["length"].min()
    top = max(references["length"].max(), wrong["length"].max(skipna=True))
    if foot > 0:
        # shows the jump and lengths that grow with the radius
        ax.set_yscale("log")
        plain_log_axis(ax.yaxis)
        ax.set_ylim(0.75 * foot, top * (top / foot) ** 0.15 * 1.2)
    plain_log_axis(ax.xaxis)


def _draw_shortest(ax: Axes, references: pd.DataFrame) -> None:
    """Draw the shortest length, with its words above it.

    The line breaks where the word changes, at the geometric mean of two radii, since the length
    may jump there.
    """
    radii = references["radius"].to_numpy()
    lengths = references["length"].to_numpy()
    # the two ends, and between them the geometric mean of each two neighbouring radii
    edges = np.sqrt(np.append(radii[0], radii) * np.append(radii, radii[-1]))
    above = ax.get_xaxis_transform()
    words = references["reference_word"].to_numpy()
    starts = [0, *np.flatnonzero(words[1:] != words[:-1]) + 1]
    for first, past in pairwise([*starts, len(words)]):
        word = words[first]
        low = edges[first]
        high = edges[past]
        shade = _WORD_SHADE.get(word, 0.02)
        ax.axvspan(low, high, color=MUTED, alpha=shade, linewidth=0, zorder=0)
        ax.text(np.sqrt(low * high), 0.97, word, transform=above, va="top", ha="center")
        ax.plot(radii[first:past], lengths[first:past], color=INK, zorder=3)


def _draw_words(ax: Axes, place: dict[str, float], radii: pd.Series[float]) -> None:
    """Draw the lengths of the words LS and RS.

    A line breaks where its word does not exist.
    """
    dense = np.geomspace(radii.min(), radii.max(), 300)
    for word, line in _WORD_LINE.items():
        totals = np.full(dense.shape, np.nan)
        for number, radius in enumerate(dense):
            path = shortest(scenario_of({**place, "radius": radius}), word)
            if path is not None:
                totals[number] = path.total
        ax.plot(dense, dense * totals, color=MUTED, linestyle=line, linewidth=0.9, zorder=2)


def _draw_wrong(ax: Axes, wrong: pd.DataFrame, palette: Palette) -> None:
    """Draw visibly wrong answers as open marks.

    Answers that do not arrive are crosses at the foot.
    """
    names = palette.names(wrong["solver"])
    for solver, look in palette.looks(wrong["solver"]).items():
        group = wrong[wrong["solver"] == solver]
        arrived = group[group["gap"].notna()]
        lost = group["radius"][group["gap"].isna()]
        dots = look.dots | {"markersize": 3.5, "markerfacecolor": "none", "zorder": 4}
        ax.plot(arrived["radius"], arrived["length"], label=names[solver][:_MOST_LETTERS], **dots)
        if len(lost):  # an empty line off the data's axes would upset the layout
            foot = np.full(len(lost), 0.03)
            ax.plot(lost, foot, transform=ax.get_xaxis_transform(), **dots | {"marker": "x"})
    if names:
        ax.legend(loc="lower right", fontsize=6.5, handletextpad=0.3)


def warm_starts(rows: pd.DataFrame) -> pd.DataFrame:
    """Cold and warm starts compared, one row per solver.

    A solver has a row if it has both for the same questions. Columns: solver; questions; cold_s and
    warm_s (median times, s); cold_success and warm_success (shares of all attempts); ratio (warm /
    cold of times) and work (of iterations). These two are medians over questions, NaN where nothing
    is counted.
    """
    attempts = rows.assign(success=success(rows).astype(float))
    attempts["iterations"] = attempts["iterations"].astype(float)
    hows = {"wall_s": "median", "success": "mean", "iterations": "median"}
    cold, warm = (
        attempts[attempts["initial_guess"] == guess].groupby(_QUESTION).agg(hows)
        for guess in ("cold", "warm")
    )
    pairs = cold.join(warm.add_suffix("_warm"), how="inner")
    pairs["ratio"] = pairs["wall_s_warm"] / pairs["wall_s"].where(pairs["wall_s"] > 0)
    pairs["work"] = pairs["iterations_warm"] / pairs["iterations"].where(pairs["iterations"] > 0)
    frame = pairs.groupby("solver").agg(
        questions=("wall_s", "size"),
        cold_s=("wall_s", "median"),
        warm_s=("wall_s_warm", "median"),
        cold_success=("success", "mean"),
        warm_success=("success_warm", "mean"),
        ratio=("ratio", "median"),
        work=("work", "median"),
    )
    return frame.reset_index()


def warm_section(results: Results) -> Section | None:
    """The section on cold and warm starts."""
    table = in_page_order(warm_starts(results.rows), results)
    if table.empty:
        return None
    caption = "Medians over questions; a success is a share of all attempts."
    text = (
        "The same questions cold, and started from the answer at the neighbouring radius (warm). "
        "Warm / cold: the median over questions of the ratio of times, and of the solver's own "
        "iterations."
    )
    lead = "Where warm / cold is below 1, the warm start saves time."
    blocks = (Table("warm-starts", caption, table, WARM_COLUMNS),)
    return Section("warm", "Cold against warm starts", text, blocks, lead)


TOPIC = Topic("length and word against radius", radius_section, General.EVERY)
WARM_TOPIC = Topic("cold against warm starts", warm_section, General.EVERY)
