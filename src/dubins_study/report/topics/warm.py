"""Cold against warm starts: what starting from the neighbouring radius's answer saves."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, columns
from dubins_study.report.elements.content import General, Picture, Section, Table, Topic
from dubins_study.report.elements.formats import count, digits, seconds, sentences, share
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.plots import Mark, quartile_lines
from dubins_study.report.elements.style import BLUE, HALF, VERMILION
from dubins_study.report.statistics.metrics import QUESTION, by_solver, success

# The table: columns of `warm_starts` with their titles, in order; the CSV file has the same keys.
COLUMNS = (
    SOLVER,
    *columns(count, questions="questions"),
    *columns(seconds, cold_s="cold, median", warm_s="warm, median"),
    *columns(digits(3), ratio="warm / cold", work="iterations, warm / cold"),
    *columns(share, cold_success="success cold", warm_success="success warm"),
)
# The figure: of each, the median as a mark and the quartiles as a bar.
MARKS = (Mark("ratio", "time", BLUE, "o"), Mark("work", "iterations", VERMILION, "s"))
_SAME = 0.02  # ratios this near to 1 are called equal


def warm_starts(rows: pd.DataFrame) -> pd.DataFrame:
    """Cold against warm starts: one row per solver that has both for the same questions.

    Columns: those of `COLUMNS`, and the quartiles of both ratios (`ratio`_q1, `ratio`_q3,
    `work`_q1, `work`_q3). A ratio is the median over questions, NaN where iterations are not
    counted; a success is a share of all attempts.
    """
    if not {"cold", "warm"} <= set(rows["initial_guess"]):
        return pd.DataFrame()
    asked = rows["scenario_id"].isin(rows.loc[rows["initial_guess"] == "warm", "scenario_id"])
    rows = rows[asked]
    attempts = rows.assign(success=success(rows).astype(float), s=rows["wall_s"])
    groups = attempts.groupby(["solver", *QUESTION])
    table = groups.agg({"s": "median", "success": "mean", "iterations": "median"})
    wide = pd.DataFrame(table.unstack("initial_guess"))
    both = wide.dropna(subset=[("success", "cold"), ("success", "warm")])
    each = both.groupby(level="solver")
    frame = pd.DataFrame({"questions": each.size()})
    frame = frame.join(each["s"].median()["s"].add_suffix("_s"))
    frame = frame.join(each["success"].mean()["success"].add_suffix("_success"))
    for key, column in (("ratio", "s"), ("work", "iterations")):
        cold, warm = both[column, "cold"].astype(float), both[column, "warm"].astype(float)
        ratios = (warm / cold.where(cold > 0)).groupby(level="solver")
        for end, q in (("_q1", 0.25), ("", 0.5), ("_q3", 0.75)):
            frame[f"{key}{end}"] = ratios.quantile(q)
    return by_solver(frame.reset_index())


def warm_section(results: Results) -> Section | None:
    """Ratios of time and iterations, as a figure, a table and sentences."""
    table, palette = warm_starts(results.rows), Palette.of_page(results)
    if table.empty:
        return None
    named = table.assign(name=table["solver"].map(palette.names(table["solver"])))
    picture = Picture(
        "warm-starts",
        "Started from the answer at the neighbouring radius against cold: time and the solver's "
        "own iterations, question by question, median (mark) and quartiles (bar).",
        quartile_lines(named, MARKS, palette, "warm / cold", limit=1.0, width=HALF),
        alt="Ratios of warm to cold time and iterations, one line per solver",
        half=True,
    )
    caption = (
        "The same questions cold, and started from the answer at the neighbouring radius. The "
        "ratios are medians over questions of warm over cold."
    )
    blocks = picture, Table("warm-starts", caption, table, COLUMNS)
    lead = "Left of 1 the warm start saves."
    return Section("warm", "Cold against warm starts", warm_text(named), blocks, lead)


def warm_text(table: pd.DataFrame) -> str:
    """What the table says, solver by solver; columns of `warm_starts`, and name."""
    time, work = _changes(table, "ratio"), _changes(table, "work")
    start = "In time a start from the neighbouring radius costs, as a median multiple:"
    return sentences(
        f"{start} {time}." if time else "",
        f"In iterations it costs: {work}." if work else "",
        _successes(table),
    )


def _changes(table: pd.DataFrame, key: str) -> str:
    """`less than a cold one for A (0.91); more for B (1.2)`."""
    ranked = table.sort_values(key)
    parts = {
        "less than a cold one for": ranked[ranked[key] < 1 - _SAME],
        "as much for": ranked[(ranked[key] - 1).abs() <= _SAME],
        "more for": ranked[ranked[key] > 1 + _SAME],
    }
    named = {
        verb: [f"{n} ({digits(3)(x)})" for n, x in zip(rows["name"], rows[key], strict=True)]
        for verb, rows in parts.items()
    }
    return "; ".join(f"{verb} {', '.join(items)}" for verb, items in named.items() if items)


def _successes(table: pd.DataFrame) -> str:
    change = table["warm_success"] - table["cold_success"]
    parts = [
        f"{row['name']} is right {verb} often ({share(row['cold_success'])} cold, "
        f"{share(row['warm_success'])} warm)"
        for verb, rows in (("more", table[change > 0]), ("less", table[change < 0]))
        for row in rows.to_dict("records")
    ]
    if not parts:
        return "No solver is right more or less often for it."
    return f"With it {', '.join(parts)}."


TOPIC = Topic("cold against warm starts", warm_section, General.EVERY)
