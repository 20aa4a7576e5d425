"""Convex problems: engines of QPs and SOCPs by size and accuracy, and what cvxpy costs."""

from __future__ import annotations

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from dubins_study.report.data.attempts import is_true
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns, marks
from dubins_study.report.elements.content import Picture, Section, Table, Topic, panels_picture
from dubins_study.report.elements.formats import count, seconds, sentences, some
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.style import (
    HALF,
    WIDE,
    Style,
    new_figure,
    power,
)
from dubins_study.report.statistics.metrics import parse_spec, success
from dubins_study.report.topics.routes import size_axes

_OWN = "own"
_METHOD = ["engine", "interface"]


def with_parts(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows with columns interface, kind (QP, SOCP), rates (their number), right and kept.

    Right: the check calls the answer optimal within the tolerance asked for. Kept: primal residual,
    dual residual and gap of both objectives are each within it.
    """
    parts = rows["label"].str.extract(r"^(?P<kind>qp|socp)-(?P<rates>\d+)-(?P<state>\w+)$")
    largest = rows[["miss", "dual_residual", "duality_gap"]].max(axis=1, skipna=False)
    return rows.assign(
        interface=rows["solver"].map(lambda spec: parse_spec(spec)[1].get("interface", _OWN)),
        kind=parts["kind"].str.upper(),
        rates=pd.to_numeric(parts["rates"]),
        right=success(rows),
        kept=is_true(largest <= rows["tolerance"]),
    )


def by_size(rows: pd.DataFrame) -> pd.DataFrame:
    """One row per engine, interface, tolerance, kind and number of turn rates.

    Columns: those; right (whether every attempt is); wall_s (the slowest problem's median).
    """
    keys = [*_METHOD, "tolerance", "kind", "rates"]
    times = rows.groupby([*keys, "label"])["wall_s"].median().groupby(keys).max()
    right = rows.groupby(keys)["right"].all()
    return pd.DataFrame({"right": right, "wall_s": times}).reset_index()


def convex_section(results: Results) -> Section | None:
    """Times by size at each tolerance, and what every engine keeps."""
    rows = with_parts(results.rows)
    rows = rows[rows["kind"].notna()]
    sizes = by_size(rows)
    if sizes.empty:
        return None
    false = int(is_true(rows["false_claim"]).sum())
    hidden = int((rows["kept"] & rows["verdict"].eq("longer")).sum())
    text = sentences(
        "An answer is right if the feasible point made from it costs at most the tolerance more "
        "than the proven optimum. Engines are asked for an absolute tolerance and no relative one; "
        "Clarabel and ECOS scale theirs by the problem's numbers.",
        f"{some(false, 'claim')} of {count(len(rows))} answers {'is' if false == 1 else 'are'} "
        "false: of an optimum, by the proof and by a residual beyond the tolerance; or that no "
        "point is feasible.",
        f"{some(hidden, 'answer')} {'keeps' if hidden == 1 else 'keep'} all three residuals within "
        f"the tolerance and {'is' if hidden == 1 else 'are'} further than that from the optimum.",
    )
    lead = "Read from left to right what more digits cost, and take a low line with filled marks."
    blocks: list[Picture | Table] = [_engines(rows)]
    timed = sizes[sizes["wall_s"].notna()]
    if len(timed):
        blocks = [_picture(timed, results), *blocks]
    return Section("convex", "The convex problems of a sequence", text, tuple(blocks), lead)


def _picture(sizes: pd.DataFrame, results: Results) -> Picture:
    """Times of own interfaces over the number of turn rates, and below what cvxpy adds."""
    caption = (
        "Median time of building and solving, of the slower of the well and the badly conditioned "
        "problem; solid: QP, dashed: SOCP. Hollow: not every answer is right. Below, the time that "
        "the same engine takes more through cvxpy."
    )
    hues = Palette.of(results.rows["engine"].unique()).hues
    alt = "Time against the number of turn rates by engine"
    return panels_picture("convex", caption, plot_sizes, alt, sizes, hues)


def plot_sizes(sizes: pd.DataFrame, hues: dict[str, tuple[str, str]], *, narrow: bool) -> Figure:
    """Two panels for each tolerance, tolerances side by side unless `narrow`; see `by_size`."""
    tolerances = sorted(sizes["tolerance"].unique(), reverse=True)
    number = len(tolerances)
    figure = new_figure(HALF, 3.0 * number) if narrow else new_figure(WIDE, 5.2)
    shape: Style = (
        {"nrows": 2 * number} if narrow else {"nrows": 2, "ncols": number, "sharey": "row"}
    )
    panels = figure.subplots(sharex=True, squeeze=False, **shape)
    pairs = panels.reshape(number, 2) if narrow else panels.T
    lines: dict[str, Line2D] = {}
    for (above, below), tolerance in zip(pairs, tolerances, strict=True):
        chosen = sizes[sizes["tolerance"] == tolerance]
        own = chosen[chosen["interface"] == _OWN]
        lines |= plot_times(above, own, hues)
        above.set_title(f"tolerance {power(tolerance)}", fontsize=8)
        keys = ["engine", "kind", "rates"]
        both = chosen[chosen["interface"] != _OWN].merge(own, on=keys, suffixes=("", "_own"))
        more = both["wall_s"] - both["wall_s_own"]
        plot_times(below, both.assign(wall_s=more.where(more > 0)), hues)
    pairs[0, 0].set_ylabel("time, own interface")
    pairs[0, 1].set_ylabel("more through cvxpy")
    (panels[-1, 0] if narrow else panels[1, number // 2]).set_xlabel("turn rates")
    key: Style = {"loc": "outside lower left", "ncols": 3 if narrow else 6, "fontsize": 7}
    figure.legend(handles=[*lines.values()], **key)
    return figure


def plot_times(
    ax: Axes, sizes: pd.DataFrame, hues: dict[str, tuple[str, str]]
) -> dict[str, Line2D]:
    """Times (s) over the number of turn rates, both axes logarithmic; returns a line an engine.

    Columns: engine, kind, rates, right, wall_s.
    """
    lines = {}
    for key, each in sizes.groupby(["engine", "kind"]):
        engine, kind = map(str, key)
        colour, marker = hues[engine]
        style: Style = {"color": colour, "marker": marker, "markersize": 4, "linewidth": 1.0}
        dashes = "-" if kind == "QP" else "--"
        ax.plot(each["rates"], each["wall_s"], linestyle=dashes, **style | {"marker": None})
        for right, filled in ((True, colour), (False, "white")):
            some_ = each[each["right"] == right]
            ax.plot(some_["rates"], some_["wall_s"], **style | {"linestyle": "none"}, mfc=filled)
        lines[engine] = Line2D([], [], label=engine, **style)
    size_axes(ax, sizes["rates"], sizes["wall_s"])
    return lines


def _engines(rows: pd.DataFrame) -> Table:
    """By engine and interface: the floor, and attempts right, kept and claimed falsely."""
    groups = rows.assign(false_claim=is_true(rows["false_claim"])).groupby(_METHOD)
    frame = groups[["right", "kept", "false_claim"]].sum()
    frame = frame.assign(floor_s=groups["floor_s"].median(), attempts=groups.size())
    frame = frame.reset_index()
    shown = (
        *columns(kind="text", engine="engine", interface="interface"),
        *columns(seconds, floor_s="floor"),
        *columns(count, attempts="attempts", right="right", kept="residuals kept"),
        *columns(count, false_claim="false claims"),
    )
    caption = (
        "Attempts at all tolerances; kept: primal and dual residual and the gap of both objectives "
        "within the tolerance. Floor: median time of a problem of one variable."
    )
    return Table("convex-engines", caption, frame, shown, marks(frame, "false_claim"))


TOPIC = Topic("convex problems", convex_section, "convex")
