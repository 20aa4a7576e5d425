"""How gaps fall as discretisations are refined."""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.data.results import Results, Settings
from dubins_study.report.elements.content import Picture, Section, Topic
from dubins_study.report.elements.formats import digits, slug
from dubins_study.report.elements.looks import Names, Palette, figure_names, labels_of
from dubins_study.report.elements.plots import parameter_lines
from dubins_study.report.statistics import metrics
from dubins_study.report.statistics.metrics import parse_spec

# Method -> the setting that controls its fineness.
SIZES = {"turn-rate-qp": "n", "heading-milp": "headings", "collocation": "n"}
PLACES = ("outside", "in a disc")
# Below these values no order is visible: a gap is rounding, a miss is within Ipopt's tolerance.
FLOOR = {"gap": 1e-13, "miss": 1e-9}
# Measure -> name of the figures, axis, caption.
_FIGURES = {
    "gap": (
        "convergence",
        "median gap",
        "median gap against the number of steps, headings or elements, and the fitted order p. "
        "Steeper is better. Marks inside each other: lines that coincide.",
    ),
    "miss": (
        "convergence-miss",
        "median miss / R",
        "the miss of uncorrected collocation. Nothing is fitted below 1e-9, Ipopt's own tolerance.",
    ),
}


def refined(rows: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """The attempts of methods that can be refined.

    Columns: series (the method and all settings in its spec except the size; categories in the
    order of tables), solver, size, place (one of `PLACES`), measure (`gap`, or `miss` for
    uncorrected collocation) and value (the gap, or the miss in radii; infinite if there is none).
    """
    sizes = sizes_of(rows, settings)
    group = rows[rows["solver"].isin(list(sizes)) & rows["region"].notna()]
    uncorrected = [spec for spec in sizes if settings[spec].get("correct") is False]
    raw = group["solver"].isin(uncorrected)
    miss = group["miss"] / group["radius"]
    of_series = group["solver"].map({spec: series(spec) for spec in sizes})
    where = np.where(group["region"].str.endswith("disc"), "in a disc", "outside")
    return pd.DataFrame(
        {
            "series": pd.Categorical(of_series, metrics.solver_order(of_series.tolist())),
            "solver": group["solver"],
            "size": group["solver"].map(sizes).astype("int64"),
            "place": pd.Categorical(where, PLACES),
            "measure": np.where(raw, "miss", "gap"),
            "value": group["gap"].clip(lower=0).mask(raw, miss).fillna(np.inf),
        }
    )


def sizes_of(rows: pd.DataFrame, settings: Settings) -> dict[str, int]:
    """Map each solver to its size, i.e. its fineness.

    The size is the value of the method's setting in `SIZES`. Solvers without one are left out.
    """
    sizes = {}
    for spec in rows["solver"].unique():
        name = parse_spec(spec)[0]
        if name in SIZES and SIZES[name] in settings.get(spec, {}):
            sizes[str(spec)] = int(settings[spec][SIZES[name]])
    return sizes


def series(spec: str) -> str:
    """A spec without its size.

    `collocation[n=20,mesh=equal]` gives `collocation[mesh=equal]`.
    """
    name, settings = parse_spec(spec)
    settings.pop(SIZES[name], None)
    others = ",".join(f"{key}={value}" for key, value in settings.items())
    if not others:
        return name
    return f"{name}[{others}]"


def _named(solvers: pd.Series, labels: Names) -> dict[str, str]:
    """Map each solver to its name without size."""
    without = {}
    for spec in solvers:
        size = f"{SIZES[parse_spec(spec)[0]]}="
        items = labels[spec].split(", ")
        without[spec] = ", ".join(item for item in items if not item.startswith(size))
    return figure_names(without)


_LINE = ["measure", "series", "place"]


def medians(attempts: pd.DataFrame) -> pd.DataFrame:
    """The median value of each series, place and size.

    `attempts` are those of `refined`. Columns: measure, series, place, size, solver (a spec of the
    series, the same at all sizes) and value (median; infinite if half have no value).
    """
    first = attempts.groupby("series")["solver"].first()
    groups = attempts.groupby([*_LINE, "size"])
    frame = groups["value"].agg(metrics.upper_quantile, q=0.5).reset_index()
    return frame.assign(solver=frame["series"].map(first).astype(object))


def orders(table: pd.DataFrame) -> pd.DataFrame:
    """The medians with the fitted order of convergence.

    The column order is added: p of median ~ size^-p, fitted over the sizes at which the median
    falls.
    """
    lines = [
        line.assign(order=_order(line, FLOOR[str(measure)]))
        for (measure, _, _), line in table.groupby(_LINE)
    ]
    return pd.concat(lines)


def _order(line: pd.DataFrame, floor: float) -> float:
    """The fitted order of one line, or NaN."""
    # up to the smallest value: beyond it the engine's own accuracy decides
    falls = line.iloc[: int(line["value"].to_numpy().argmin()) + 1]
    return metrics.fitted_order(falls["size"], falls["value"], floor)


def convergence_section(results: Results) -> Section | None:
    """The section with values against sizes, and fitted orders."""
    attempts = refined(results.rows, results.settings)
    if attempts.empty:
        return None
    lines = orders(medians(attempts))
    named = _named(lines["solver"].drop_duplicates(), labels_of(results))
    lines["label"] = lines["solver"].map(named)
    pictures = _pictures(lines, Palette.of_page(results))
    text = (
        "A constant turn rate costs the integral of |ν₃ Δu| over the steps in which it should "
        "switch. ν₃ leaves zero quadratically where an arc meets a straight, and linearly where "
        "two arcs meet. So steps of 1/N should cost 1/N³ outside the discs and 1/N² inside; a "
        "grid of final headings should cost the same. Uncorrected collocation at p of Radau's "
        "points should miss the target by 1/N to the power 2p − 1."
    )
    lead = (
        "Read the slope of a line: twice the steps divide the gap by 2 to the power p. The gap "
        "falls faster outside the turning circles than inside."
    )
    return Section("convergence", "Order of convergence", text, tuple(pictures), lead)


def _pictures(lines: pd.DataFrame, palette: Palette) -> list[Picture]:
    """Plots of value against size.

    There is one for each measure and place. The table `lines` gets a column name, and its places
    become ordered categories.
    """
    lines["place"] = pd.Categorical(lines["place"], PLACES)
    order = lines["order"].map(digits(3), na_action="ignore")
    lines["name"] = (lines["label"] + ": p = " + order).fillna(lines["label"])
    positive = lines[lines["value"].between(0, np.inf, inclusive="neither")]
    pictures = []
    for (measure, place), group in positive.groupby(["measure", "place"]):
        stem, ylabel, text = _FIGURES[str(measure)]
        xlabel = "steps, headings or elements N"
        figure = parameter_lines(group, palette, xlabel, ylabel)
        caption = f"Targets {place}: {text}"
        pictures.append(Picture(f"{stem}-{slug(str(place))}", caption, figure, caption, half=True))
    return pictures


TOPIC = Topic("the order of convergence", convergence_section, "convergence")
