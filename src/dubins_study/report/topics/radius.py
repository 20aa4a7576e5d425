"""The section on the radius sweep."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from dubins_study.report.data.attempts import EXACT, SUCCESSES
from dubins_study.report.data.results import Results
from dubins_study.report.elements.axes import duration, log_axis, mark_limit, plain_log_axis
from dubins_study.report.elements.columns import SOLVER, columns, marks
from dubins_study.report.elements.content import Picture, Section, Table
from dubins_study.report.elements.formats import count, digits
from dubins_study.report.elements.looks import LINES, Palette
from dubins_study.report.elements.plots import parameter_lines
from dubins_study.report.elements.style import HALF, INK, MUTED, WIDE, new_figure
from dubins_study.report.elements.topic import General, Topic
from dubins_study.report.statistics.methods import best_solvers
from dubins_study.report.statistics.metrics import by_solver, circle_radius, runs_of
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.scenario import Scenario

_FEWEST_RADII = 4  # fewer do not show a curve
_PLACE = ["x", "y", "heading", "target_x", "target_y"]
_SINGLE_WORDS = ("LS", "RS")
VISIBLE = 0.01  # relative; an answer that is longer by less lies on the line of the shortest ones


class Span(NamedTuple):
    """A range of radii with one shortest word."""

    word: str
    left: float  # radius
    right: float
    first: int  # row of `Sweep.shortest`
    past: int  # the row after the last


@dataclass(frozen=True, eq=False)
class Sweep:
    """What the figure of one sweep draws; lengths and radii in the scenario's unit."""

    label: str  # of its scenarios
    circle: float  # the radius at which a turning circle passes through the target, R*
    shortest: pd.DataFrame  # radius, length, word; one row per radius, rising
    spans: tuple[Span, ...]  # of the words, by rising radius
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
    """The sweep of some rows of `sweep_rows`."""
    first = rows.iloc[0]
    line = _shortest(rows)
    missed = ~rows["verdict"].isin(SUCCESSES)
    wrong = rows[missed & ~(rows["gap"] <= VISIBLE)]
    return Sweep(
        label,
        circle_radius(*(first[key] for key in _PLACE)),
        line,
        _spans(line),
        single_words(first, line["radius"].min(), line["radius"].max()),
        wrong[["solver", "radius", "length"]].assign(arrives=wrong["gap"].notna()),
        cold(rows).groupby(["solver", "radius"], observed=True)["wall_s"].median().reset_index(),
    )


def cold(rows: pd.DataFrame) -> pd.DataFrame:
    """The cold attempts; all of them if there are none."""
    chosen = rows[rows["initial_guess"] == "cold"]
    return chosen if len(chosen) else rows


def answers(rows: pd.DataFrame) -> pd.DataFrame:
    """One row per solver: how its answers along the sweeps are wrong.

    Columns solver, attempts, right, little (longer by at most `VISIBLE`), longer (by more), lost
    (no path that arrives), most (largest gap of a path that arrives).
    """
    right = rows["verdict"].isin(SUCCESSES)
    little = ~right & (rows["gap"] <= VISIBLE)
    lost = ~right & rows["gap"].isna()
    kinds = {"right": right, "little": little, "longer": ~right & ~little & ~lost, "lost": lost}
    groups = rows.assign(**kinds).groupby("solver", observed=True)
    frame = groups[list(kinds)].sum().assign(attempts=groups.size(), most=groups["gap"].max())
    return by_solver(frame.reset_index())


def _shortest(rows: pd.DataFrame) -> pd.DataFrame:
    """Word and length at each radius; the length is the closed form's answer where there is one."""
    known = rows[rows["reference_word"].notna()].sort_values("radius").drop_duplicates("radius")
    exact = rows[rows["solver"] == EXACT].drop_duplicates("radius").set_index("radius")["length"]
    length = known["radius"].map(exact).fillna(known["reference"]).astype(float)
    frame = pd.DataFrame(
        {"radius": known["radius"], "length": length, "word": known["reference_word"]}
    )
    return frame.reset_index(drop=True)


def _spans(line: pd.DataFrame) -> tuple[Span, ...]:
    """Where each word is the shortest: it changes at the geometric mean of two radii."""
    radii = line["radius"].tolist()
    spans = []
    for first, past, word in runs_of(line["word"].tolist()):
        left = radii[0] if first == 0 else math.sqrt(radii[first - 1] * radii[first])
        right = radii[-1] if past == len(radii) else math.sqrt(radii[past - 1] * radii[past])
        spans.append(Span(word, left, right, first, past))
    return tuple(spans)


def single_words(row: pd.Series, low: float, high: float) -> pd.DataFrame:
    """The lengths of LS and RS at radii from `low` to `high`, for the start and target of a row."""
    radii = np.geomspace(low, high, 300)
    where: dict[str, Any] = {key: float(row[key]) for key in _PLACE}
    records = []
    for word in _SINGLE_WORDS:
        for radius in radii:
            path = shortest(Scenario(**where, radius=radius), word)
            records.append((word, radius, math.nan if path is None else path.total * radius))
    return pd.DataFrame.from_records(records, columns=["word", "radius", "length"])


_CLEAR = 1.15  # so far above the shortest length a line has room for its name
_MOST_LETTERS = 34  # of a solver's name in the figure
_WORD_SHADE = {"LS": 0.06, "RS": 0.12, "RL": 0.22, "LR": 0.3}
_WORD_LINE = {"LS": LINES[1], "RS": LINES[2]}


def plot_length(ax: Axes, sweep: Sweep, palette: Palette) -> None:
    """Draw the shortest length over radius, its words and R*, and every answer visibly wrong.

    The line breaks where the word changes, since the length may jump there.
    """
    radii, lengths = sweep.shortest["radius"].to_numpy(), sweep.shortest["length"].to_numpy()
    ax.set(xscale="log", xlim=(radii.min(), radii.max()))
    plain_log_axis(ax.xaxis)
    for span in sweep.spans:
        shade = _WORD_SHADE.get(span.word, 0.02)
        ax.axvspan(span.left, span.right, color=MUTED, alpha=shade, linewidth=0, zorder=0)
        middle, across = np.sqrt(span.left * span.right), ax.get_xaxis_transform()
        ax.text(middle, 0.97, span.word, transform=across, va="top", ha="center")
        ax.plot(radii[span.first : span.past], lengths[span.first : span.past], color=INK, zorder=3)
    for word, group in sweep.single_words.groupby("word"):
        line = _WORD_LINE[str(word)]
        ax.plot(
            group["radius"], group["length"], color=MUTED, linestyle=line, linewidth=0.9, zorder=2
        )
        _name_word(ax, group.dropna(), sweep, str(word))
    _wrong_answers(ax, sweep.wrong, palette)
    _circle_mark(ax, sweep.circle, f"R* = {digits(4)(sweep.circle)}")
    longest = float(np.nanmax([lengths.max(), *sweep.wrong["length"]]))
    _length_scale(ax, lengths.min(), longest)


def _name_word(ax: Axes, line: pd.DataFrame, sweep: Sweep, word: str) -> None:
    """Name the line of one word where it is clear of the shortest words, which have their names."""
    lengths = np.interp(line["radius"], sweep.shortest["radius"], sweep.shortest["length"])
    clear = line[line["length"] > _CLEAR * lengths]
    if clear.empty:
        return
    middle = clear.iloc[len(clear) // 2]
    point = (middle["radius"], middle["length"])
    ax.annotate(word, point, xytext=(-3, 3), textcoords="offset points", ha="right", color=MUTED)


def _length_scale(ax: Axes, foot: float, top: float) -> None:
    ax.set_ylabel("length")
    if foot > 0:  # a logarithmic scale shows the jump and lengths that grow with the radius
        ax.set(yscale="log", ylim=(0.75 * foot, top * (top / foot) ** 0.15 * 1.2))
        plain_log_axis(ax.yaxis)
    else:
        ax.set_ylim(0, 1.22 * top or 1.0)
        ax.yaxis.set_major_locator(MaxNLocator(5))


def _wrong_answers(ax: Axes, wrong: pd.DataFrame, palette: Palette) -> None:
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


def _circle_mark(ax: Axes, circle: float, text: str = "") -> None:
    """A dotted line at R*, which a target straight ahead does not have."""
    low, high = ax.get_xlim()
    if not low < circle < high:
        return
    ax.axvline(circle, color=MUTED, linewidth=0.8, linestyle=(0, (1, 2)))
    above = ax.get_xaxis_transform()
    ax.text(circle, 1.02, text, transform=above, ha="center", fontsize=8, color=MUTED)


def radius_section(results: Results) -> Section | None:
    """One figure per sweep, and how the answers along the sweeps are wrong."""
    rows_of_sweeps = sweep_rows(results.rows)
    if not rows_of_sweeps:
        return None
    rows, palette = pd.concat(list(rows_of_sweeps.values())), Palette.of_page(results)
    solvers = best_solvers(cold(rows))
    sweeps = [sweep(label, group) for (_, label), group in rows_of_sweeps.items()]
    blocks: list[Picture | Table] = [
        _picture(number, each, palette) for number, each in enumerate(sweeps, start=1)
    ]
    if any(np.isfinite(each.circle) for each in sweeps):
        blocks.append(_time_picture(sweeps, solvers, palette))
    blocks.append(_answers(answers(rows)))
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


_VISIBLE = f"{100 * VISIBLE:g} %"


def _picture(number: int, sweep: Sweep, palette: Palette) -> Picture:
    figure = new_figure(HALF, 2.9)
    ax = figure.add_subplot()
    plot_length(ax, sweep, palette)
    ax.set_xlabel("turning radius R")
    label = sweep.label
    caption = f"{label[:1].upper()}{label[1:]}. Length units; R* = {digits(5)(sweep.circle)}."
    return Picture(f"radius-{number}", caption, figure, f"Length over radius, {label}", half=True)


def _time_picture(sweeps: Sequence[Sweep], solvers: list[str], palette: Palette) -> Picture:
    """The median time of all sweeps over R / R*, a line per solver."""
    times = [sweep.times.assign(place=sweep.times["radius"] / sweep.circle) for sweep in sweeps]
    every = pd.concat(times)
    every = every[
        every["solver"].isin(solvers) & np.isfinite(every["place"]) & (every["place"] > 0)
    ]
    bins = 10 ** (np.round(_BINS * np.log10(every["place"])) / _BINS)
    medians = every.groupby(["solver", bins])["wall_s"].median().reset_index()
    names = palette.names(solvers)
    table = by_solver(medians).assign(name=lambda lines: lines["solver"].map(names))
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


_BINS = 8  # of the time's figure, in a decade of radii


def _answers(frame: pd.DataFrame) -> Table:
    shown = (
        SOLVER,
        *columns(count, attempts="attempts", right="shortest"),
        *columns(count, little=f"up to {_VISIBLE} longer", longer="more", lost="no path"),
        *columns(digits(2), most="largest gap"),
    )
    caption = (
        "What the solvers answer along the sweeps, cold and warm: the shortest path within the "
        "check's tolerance, a longer one, or none that arrives. The gap is relative."
    )
    return Table("radius-answers", caption, frame, shown, marks(frame, "longer", "lost"))


TOPIC = Topic("length, time and word against radius", radius_section, General.EVERY)
