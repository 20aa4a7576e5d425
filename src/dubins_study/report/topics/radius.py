"""The section on the radius sweep."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from dubins_study.report.data.attempts import EXACT, SUCCESSES
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, columns, marks
from dubins_study.report.elements.content import General, Picture, Section, Table, Topic
from dubins_study.report.elements.formats import count, digits
from dubins_study.report.elements.looks import LINES, Palette
from dubins_study.report.elements.plots import parameter_lines
from dubins_study.report.elements.style import (
    HALF,
    INK,
    MUTED,
    WIDE,
    Style,
    duration,
    log_axis,
    mark_limit,
    new_figure,
    plain_log_axis,
)
from dubins_study.report.statistics.methods import best_solvers
from dubins_study.report.statistics.metrics import by_solver, circle_radius, runs_of
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.scenario import Scenario

_FEWEST_RADII = 4  # fewer do not show a curve
_PLACE = ["x", "y", "heading", "target_x", "target_y"]
VISIBLE = 0.01  # relative; an answer that is longer by less lies on the line of the shortest ones
_VISIBLE = f"{100 * VISIBLE:g} %"
_MOST_LETTERS = 34  # of a solver's name in the figure
_WORD_SHADE = {"LS": 0.06, "RS": 0.12, "RL": 0.22, "LR": 0.3}
_WORD_LINE = {"LS": LINES[1], "RS": LINES[2]}  # of the paper's two words
_BINS = 8  # of the time's figure, in a decade of radii

COLUMNS = (
    SOLVER,
    *columns(count, attempts="attempts", right="shortest"),
    *columns(count, little=f"up to {_VISIBLE} longer", longer="more", lost="no path"),
    *columns(digits(2), most="largest gap"),
)


@dataclass(frozen=True, eq=False)
class Sweep:
    """What the figure of one sweep draws; lengths and radii in the scenario's unit."""

    label: str  # of its scenarios
    circle: float  # the radius at which a turning circle passes through the target, R*
    shortest: pd.DataFrame  # radius, length, word; one row per radius, rising
    single_words: pd.DataFrame  # word, radius, length (NaN where the word does not exist)
    wrong: pd.DataFrame  # solver, radius, length, arrives; the answers that are visibly wrong
    times: pd.DataFrame  # solver, radius, wall_s (median of cold attempts, s)


def sweep_rows(rows: pd.DataFrame) -> dict[tuple[str, str], pd.DataFrame]:
    """(experiment, label) -> rows, for each label with one start and target at many radii."""
    best = rows[rows["branch"] == "best"]
    groups = best.groupby(["experiment", "label"], sort=True)
    return {
        (str(experiment), str(label)): group
        for (experiment, label), group in groups
        if group.loc[group["reference_word"].notna(), "radius"].nunique() >= _FEWEST_RADII
        and len(group[_PLACE].drop_duplicates()) == 1
    }


def sweep(label: str, rows: pd.DataFrame) -> Sweep:
    """The sweep of some rows of `sweep_rows`; its shortest lengths are the closed form's if any."""
    known = rows[rows["reference_word"].notna()].sort_values("radius").drop_duplicates("radius")
    exact = rows[rows["solver"] == EXACT].drop_duplicates("radius").set_index("radius")["length"]
    length = known["radius"].map(exact).fillna(known["reference"]).astype(float)
    wrong = rows[~rows["verdict"].isin(SUCCESSES) & ~(rows["gap"] <= VISIBLE)]
    place: dict[str, Any] = {key: float(rows[key].iloc[0]) for key in _PLACE}
    radii = np.geomspace(known["radius"].min(), known["radius"].max(), 300)
    return Sweep(
        label,
        circle_radius(**place),
        pd.DataFrame(
            {"radius": known["radius"], "length": length, "word": known["reference_word"]}
        ),
        pd.DataFrame(
            {
                "word": word,
                "radius": radius,
                "length": math.nan if path is None else path.total * radius,
            }
            for word in _WORD_LINE
            for radius in radii
            for path in [shortest(Scenario(**place, radius=radius), word)]
        ),
        wrong[["solver", "radius", "length"]].assign(arrives=wrong["gap"].notna()),
        cold(rows).groupby(["solver", "radius"], observed=True)["wall_s"].median().reset_index(),
    )


def cold(rows: pd.DataFrame) -> pd.DataFrame:
    """The cold attempts; all of them if there are none."""
    chosen = rows[rows["initial_guess"] == "cold"]
    return chosen if len(chosen) else rows


def answers(rows: pd.DataFrame) -> pd.DataFrame:
    """One row per solver: how its answers along the sweeps are wrong.

    Columns: those of `COLUMNS`; little is longer by at most `VISIBLE`, most the largest gap of a
    path that arrives.
    """
    right = rows["verdict"].isin(SUCCESSES)
    little = ~right & (rows["gap"] <= VISIBLE)
    lost = ~right & rows["gap"].isna()
    kinds = {"right": right, "little": little, "longer": ~right & ~little & ~lost, "lost": lost}
    groups = rows.assign(**kinds).groupby("solver", observed=True)
    frame = groups[list(kinds)].sum().assign(attempts=groups.size(), most=groups["gap"].max())
    return by_solver(frame.reset_index())


def radius_section(results: Results) -> Section | None:
    """One figure per sweep, and how the answers along the sweeps are wrong."""
    rows_of_sweeps = sweep_rows(results.rows)
    if not rows_of_sweeps:
        return None
    rows, palette = pd.concat(list(rows_of_sweeps.values())), Palette.of_page(results)
    sweeps = [sweep(label, group) for (_, label), group in rows_of_sweeps.items()]
    blocks: list[Picture | Table] = []
    for number, each in enumerate(sweeps, start=1):
        figure = new_figure(HALF, 2.9)
        _draw_sweep(figure.add_subplot(), each, palette)
        alt = f"Length over radius, {each.label}"
        name = f"{each.label[:1].upper()}{each.label[1:]}"
        caption = f"{name}. Length units; R* = {digits(5)(each.circle)}."
        blocks.append(Picture(f"radius-{number}", caption, figure, alt, half=True))
    if any(np.isfinite(each.circle) for each in sweeps):
        blocks.append(_time_picture(sweeps, best_solvers(cold(rows)), palette))
    caption = (
        "What the solvers answer along the sweeps, cold and warm: the shortest path within the "
        "check's tolerance, a longer one, or none that arrives. The gap is relative."
    )
    table = answers(rows)
    wrong = marks(table, "longer", "lost")
    blocks.append(Table("radius-answers", caption, table, COLUMNS, wrong))
    text = (
        "At R* = r² / (2 |Y|) a turning circle passes through the target (r is its distance, Y its "
        "offset to the left of the start heading). Beyond it the target lies inside the circle, "
        "the word changes, and where it lay on the circle's front half the length jumps. Heavy: "
        "the shortest length, with its word at the top; grey: LS (dashed) and RS (dotted) "
        f"where they exist; open marks are answers more than {_VISIBLE} longer, crosses at "
        "the foot those that do not arrive."
    )
    lead = (
        "See where the target enters a turning circle, at R*: there the word changes, the length "
        "jumps where the target was ahead, and some solvers take longer."
    )
    title = "Length, time and word against radius"
    return Section("radius", title, text, tuple(blocks), lead)


def _draw_sweep(ax: Axes, sweep: Sweep, palette: Palette) -> None:
    """Draw the shortest length over radius, its words and R*, and every answer visibly wrong.

    The line breaks where the word changes, at the geometric mean of two radii, since the length
    may jump there.
    """
    radii, lengths = sweep.shortest["radius"].to_numpy(), sweep.shortest["length"].to_numpy()
    above = ax.get_xaxis_transform()
    ax.set(xscale="log", xlim=(radii[0], radii[-1]), xlabel="turning radius R", ylabel="length")
    plain_log_axis(ax.xaxis)
    edges = np.sqrt(np.append(radii[0], radii) * np.append(radii, radii[-1]))
    for first, past, word in runs_of(sweep.shortest["word"].tolist()):
        low, high, shade = edges[first], edges[past], _WORD_SHADE.get(word, 0.02)
        ax.axvspan(low, high, color=MUTED, alpha=shade, linewidth=0, zorder=0)
        ax.text(np.sqrt(low * high), 0.97, word, transform=above, va="top", ha="center")
        ax.plot(radii[first:past], lengths[first:past], color=INK, zorder=3)
    for word, line in _WORD_LINE.items():
        group = sweep.single_words[sweep.single_words["word"] == word]
        dashes: Style = {"color": MUTED, "linestyle": line, "linewidth": 0.9, "zorder": 2}
        ax.plot(group["radius"], group["length"], **dashes)
    _draw_wrong(ax, sweep.wrong, palette)
    if radii[0] < sweep.circle < radii[-1]:  # infinite for a target straight ahead
        mark_limit(ax, sweep.circle)
        name: Style = {"transform": above, "ha": "center", "fontsize": 8, "color": MUTED}
        ax.text(sweep.circle, 1.02, f"R* = {digits(4)(sweep.circle)}", **name)
    foot, top = lengths.min(), float(np.nanmax([lengths.max(), *sweep.wrong["length"]]))
    if foot > 0:  # a logarithmic scale shows the jump and lengths that grow with the radius
        ax.set(yscale="log", ylim=(0.75 * foot, top * (top / foot) ** 0.15 * 1.2))
        plain_log_axis(ax.yaxis)
    else:
        ax.set_ylim(0, 1.22 * top or 1.0)
        ax.yaxis.set_major_locator(MaxNLocator(5))


def _draw_wrong(ax: Axes, wrong: pd.DataFrame, palette: Palette) -> None:
    """Draw visibly wrong answers; those that do not arrive as crosses at the foot."""
    looks, names = palette.looks(wrong["solver"]), palette.names(wrong["solver"])
    for solver, look in looks.items():
        group = wrong[wrong["solver"] == solver]
        arrived, lost = group[group["arrives"]], group[~group["arrives"]]
        dots = look.dots | {"markersize": 3.5, "markerfacecolor": "none", "zorder": 4}
        dots |= {"label": names[solver][:_MOST_LETTERS]}
        ax.plot(arrived["radius"], arrived["length"], **dots)
        if len(lost):  # an empty line off the data's axes would upset the layout
            foot = np.full(len(lost), 0.03)
            dots |= {"marker": "x"} | ({"label": "_again"} if len(arrived) else {})
            ax.plot(lost["radius"], foot, transform=ax.get_xaxis_transform(), **dots)
    if looks:
        ax.legend(loc="lower right", fontsize=6.5, handletextpad=0.3)


def _time_picture(sweeps: list[Sweep], solvers: list[str], palette: Palette) -> Picture:
    """The median time of all sweeps over R / R*, a line per solver."""
    times = pd.concat(
        [each.times.assign(place=each.times["radius"] / each.circle) for each in sweeps]
    )
    times = times[times["solver"].isin(solvers) & (times["place"] > 0)]
    bins = 10 ** (np.round(_BINS * np.log10(times["place"])) / _BINS)
    table = by_solver(times.groupby(["solver", bins])["wall_s"].median().reset_index())
    table["name"] = table["solver"].map(palette.names(solvers))
    caption = (
        "Median time of a cold attempt over all sweeps, against R / R*: of the closed form and of "
        "each formulation's solver that is most surely right. Right of 1 the target lies inside "
        "the circle."
    )
    axes = "turning radius R / R*", "median time"
    figure = parameter_lines(table, "place", "wall_s", palette, *axes, width=WIDE)
    log_axis(figure.axes[0].yaxis, duration)
    mark_limit(figure.axes[0], 1.0)
    return Picture("radius-time", caption, figure, "Median time over the radius")


TOPIC = Topic("length, time and word against radius", radius_section, General.EVERY)
