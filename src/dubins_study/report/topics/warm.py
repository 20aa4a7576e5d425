"""Cold against warm starts: what starting from the neighbouring radius's answer saves."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, columns
from dubins_study.report.elements.content import General, Section, Table, Topic
from dubins_study.report.elements.formats import count, digits, seconds, share
from dubins_study.report.statistics.metrics import QUESTION, by_solver, success

# Columns of `warm_starts` with their titles, in order; the CSV file has the same keys.
COLUMNS = (
    SOLVER,
    *columns(count, questions="questions"),
    *columns(seconds, cold_s="cold, median", warm_s="warm, median"),
    *columns(digits(3), ratio="warm / cold", work="iterations, warm / cold"),
    *columns(share, cold_success="success cold", warm_success="success warm"),
)


def warm_starts(rows: pd.DataFrame) -> pd.DataFrame:
    """Cold against warm starts: one row per solver that has both for the same questions.

    A ratio is the median over questions, NaN where iterations are not counted; a success is a share
    of all attempts.
    """
    if not {"cold", "warm"} <= set(rows["initial_guess"]):
        return pd.DataFrame()
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
        frame[key] = (warm / cold.where(cold > 0)).groupby(level="solver").median()
    return by_solver(frame.reset_index())


def warm_section(results: Results) -> Section | None:
    """Times, iterations and success, cold and warm."""
    table = warm_starts(results.rows)
    if table.empty:
        return None
    caption = "Medians over questions; a success is a share of all attempts."
    text = (
        "The same questions cold, and started from the answer at the neighbouring radius. Warm / "
        "cold is the median over questions of their ratios, of the time and of the solver's own "
        "iterations."
    )
    lead = "Where warm / cold is below 1 the warm start saves."
    blocks = (Table("warm-starts", caption, table, COLUMNS),)
    return Section("warm", "Cold against warm starts", text, blocks, lead)


TOPIC = Topic("cold against warm starts", warm_section, General.EVERY)
