"""The section on tours: proofs, and prices of grids.

It shows what is proved by size and density, and what a grid of headings costs.
"""

from __future__ import annotations

import math
from collections.abc import Hashable
from typing import Any

import numpy as np
import pandas as pd

from dubins_study.report.data.attempts import EXACT, TRIAL, is_true, legs_of
from dubins_study.report.data.results import Results, Settings
from dubins_study.report.elements.columns import SOLVER, Column, columns
from dubins_study.report.elements.content import (
    Block,
    General,
    Picture,
    Section,
    Table,
    Topic,
    panels_picture,
)
from dubins_study.report.elements.formats import count, digits, seconds, sentences, share
from dubins_study.report.elements.identity import with_share
from dubins_study.report.elements.looks import distinct, in_page_order
from dubins_study.report.elements.plots import Mark
from dubins_study.report.statistics.intervals import scenario_shares
from dubins_study.report.statistics.methods import stratum_order
from dubins_study.report.statistics.metrics import upper_quantile
from dubins_study.report.topics.routes import by_size, palette_of, plot_sizes, usual_limit
from dubins_study.study.words import Claim

TITLE = "Tours of any order"
TOURS = "tours"  # the key of their experiments
# The largest median gap of each class -> its mark, from light to dark.
GAPS = {
    1e-6: Mark("up to 1e-6", colour="#eef4f9"),
    1e-2: Mark("up to 1 %", colour="#cfe2f0"),
    1e-1: Mark("up to 10 %", colour="#a3c7e0"),
    1e300: Mark("more", colour="#6a9cc4"),
    math.inf: Mark("most have no tour", colour="#2f4c69"),
}
# Formulations with a program that an engine solves to a proved optimum, and the question itself.
PROVING = ("tour MILP", "tour circuit")
_DISJUNCTION = "disjunction"
_STRAIGHT_FIRST = "order then headings"  # the formulation of both orders by straight lines
# What proved tours are compared with.
BEST_OF_GRID = "best tour of"
_STRAIGHT = "order by straight lines, best headings"
_ALTERNATING = "that order, every other leg straight"
# Ends of the engines' words for an optimum of their program, in lower case.
_OPTIMAL = ("optimal", "gaplimit", "glp_opt", "glp_emipgap")
# The gap that an engine leaves in its program, in the messages of `solvers.tour.graph`
_OWN_GAP = r"gap ([0-9.e+-]+), of "
_WITHIN_S = (1, 10, 100)


def with_points(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows with four more columns.

    - points: the number of points.
    - closes: for a solver of the question itself, whether the tour is proved shortest. For an
      engine with a program of its own, whether it solved that to the optimum. False if late.
    - own_gap: the gap that the engine left in its own program; NaN without a tour.
    - bound_gap: how far the solver's bound lies below the shortest length, relative to it; NaN
      without a bound.
    """
    points = legs_of(rows) - is_true(rows["closed"])
    engine_optimal = rows["native_status"].fillna("").str.lower().str.endswith(_OPTIMAL)
    proved = rows["claim"].eq(Claim.OPTIMAL) & rows["verdict"].eq("optimal")
    solves_question = rows["solver"].eq(EXACT) | rows["formulation"].eq(_DISJUNCTION)
    has_program = rows["formulation"].isin(PROVING)
    ended = proved.where(solves_question, engine_optimal & has_program)
    high = rows["reference_high"]
    below = (high - rows["lower_bound"]).clip(lower=0.0) / high
    reported = rows["message"].fillna("").str.extract(_OWN_GAP, expand=False)
    return rows.assign(
        points=points,
        closes=ended & ~is_true(rows["late"]),
        own_gap=reported.astype(np.float64),
        bound_gap=below,
    )


def by_points(rows: pd.DataFrame) -> pd.DataFrame:
    """The table of `by_size`, by the number of points.

    Its successes are the questions closed, its trials those asked; both are 0 for a method that
    proves nothing. The gap is an upper bound where the shortest length is not proved.
    """
    cells = by_size(rows.assign(left_open=False), "points", "closes")
    proves = cells["solver"].isin(of_provers(rows)["solver"])
    numbers = ["successes", "trials"]
    return cells.assign(**{name: cells[name].where(proves, 0) for name in numbers})


def of_provers(rows: pd.DataFrame) -> pd.DataFrame:
    """The attempts of solvers that can prove an optimum."""
    proving = rows["solver"].eq(EXACT) | rows["formulation"].isin((*PROVING, _DISJUNCTION))
    return rows[rows["solver"].isin(rows["solver"][proving])]


def asked_of_most(rows: pd.DataFrame) -> pd.DataFrame:
    """The attempts at the questions that most solvers met.

    If all solvers met the same questions, all attempts come back.
    """
    solvers = rows.groupby("scenario_id")["solver"].transform("nunique")
    asked: pd.DataFrame = rows[solvers == solvers.max()]
    return asked


def closed_within(rows: pd.DataFrame) -> pd.DataFrame:
    """How many questions each solver closes in time.

    The times are 1, 10 and 100 s. Only questions whose limit is at least as long count. Indexed by
    solver; the columns `in_1_s`, `in_10_s` and `in_100_s` hold texts such as `5/6`, missing if
    there are no questions.
    """
    columns = {}
    for limit in _WITHIN_S:
        asked = rows[rows["limit_s"] >= limit]
        closed = asked["closes"] & (asked["wall_s"] <= limit)
        counts = closed.groupby(asked["solver"]).agg(["sum", "size"]).astype(int).astype(str)
        columns[f"in_{limit}_s"] = counts["sum"] + "/" + counts["size"]
    return pd.DataFrame(columns)


def by_engine(rows: pd.DataFrame) -> pd.DataFrame:
    """Medians of each solver's attempts, one row per solver.

    Columns: solver; those of `with_share` for closes; nodes (of attempts that count some); gap
    (infinite without an answer); own_gap (1 without a tour, NaN of solvers that report none);
    bound_gap (1 without a bound, NaN of solvers that give none); false_bounds (their number);
    memory_mib; wall_s.
    """
    # Of a solver that reports gaps, an attempt without one counts as 1: nothing is closed.
    reported = rows.groupby("solver")[["own_gap", "bound_gap"]].transform("count") > 0
    open_gaps = rows[["own_gap", "bound_gap"]].fillna(1.0).where(reported)
    counted = rows.assign(gap=rows["gap"].fillna(np.inf), **open_gaps)
    medians = ["iterations", "gap", "own_gap", "bound_gap", "memory_mib", "wall_s"]
    groups = counted.groupby("solver", sort=False)
    frame = groups[medians].agg(upper_quantile, q=0.5).rename(columns={"iterations": "nodes"})
    frame["false_bounds"] = is_true(rows["false_bound"]).groupby(rows["solver"]).sum()
    shares = scenario_shares(of_provers(rows), by=["solver"], success="closes", scenario=TRIAL)
    shares = shares.reindex(frame.index).fillna({"successes": 0, "trials": 0})
    return with_share(frame, "closes", shares["successes"], shares["trials"]).reset_index()


def against_proof(rows: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """Answers to questions with a proved tour.

    Each such question has at most one answer of each kind. Kinds are the best tour of a grid, by
    any engine that has proved it, and both orders by straight lines. Columns: those of the rows;
    kind; other_order (whether the answer passes the points in another order than the proved tour; a
    closed tour may be driven either way).
    """
    proved = rows[rows["solver"].eq(EXACT) & rows["closes"]].drop_duplicates("scenario_id")
    orders = proved.set_index("scenario_id")["visit_order"]
    answers = rows.assign(kind=[_kind_of(row, settings) for row in rows.to_dict("records")])
    known = (
        answers["scenario_id"].isin(orders.index) & answers["gap"].notna() & answers["kind"].ne("")
    )
    chosen = answers[known].drop_duplicates(["kind", "scenario_id"])
    other = [
        not _same_order(row["visit_order"], orders[row["scenario_id"]], row["closed"] is True)
        for row in chosen.to_dict("records")
    ]
    return chosen.assign(other_order=np.array(other, dtype=bool))


def by_kind(compared: pd.DataFrame) -> pd.DataFrame:
    """Comparisons with proved tours, by kind of answer.

    `compared` is the frame of `against_proof`. Columns: kind; those of `with_share` for refuted
    (the proved tour is shorter by more than the tolerance) and for other_order; excess and most,
    the median and the largest gap.
    """
    groups = compared.groupby("kind", sort=False)
    frame = groups[["gap"]].agg(["median", "max"]).set_axis(["excess", "most"], axis=1)
    trials = groups.size()
    refuted = compared["verdict"].eq("longer").groupby(compared["kind"]).sum()
    frame = with_share(frame, "refuted", refuted.reindex(frame.index), trials)
    return with_share(frame, "other_order", groups["other_order"].sum(), trials).reset_index()


def _kind_of(row: dict[Hashable, Any], settings: Settings) -> str:
    """The kind of a compared answer, or empty.

    Answers are compared with proved tours. An answer that is not compared has no kind.
    """
    values = settings.get(row["solver"], {})
    if row["formulation"] == _STRAIGHT_FIRST:
        if values.get("order") == "alternating":
            return _ALTERNATING
        return _STRAIGHT
    if row["closes"] and values.get("costs") == "lengths" and not values.get("polish"):
        return f"{BEST_OF_GRID} {values['headings']} headings"
    return ""


def _same_order(one: Any, other: Any, round_trip: bool) -> bool:
    """Whether two tours have the same order.

    A round trip may also be driven backwards.
    """
    order, proved = (np.atleast_1d(each).tolist() for each in (one, other))
    # a round trip may be driven backwards
    return order == proved or (round_trip and order[::-1] == proved)


def tours_section(results: Results) -> Section | None:
    """The section on tours.

    It shows what closes, and compares proved tours with those of a grid and of straight lines.
    """
    if results.rows.empty:
        return None
    rows = with_points(results.rows)
    cells = in_page_order(by_points(rows), results)
    strata = stratum_order(results, cells["label"])
    compared = against_proof(rows, results.settings)
    blocks: list[Block] = [_closed_picture(rows, cells, strata, results)]
    closed = closed_within(of_provers(rows))
    engines = by_engine(asked_of_most(rows)).merge(closed, "left", on="solver")
    blocks.append(_engines(in_page_order(engines, results)))
    if len(compared):
        blocks.append(_compared(by_kind(compared)))
    lead = (
        "Read along a line up to how many points a method closes its program. The last table "
        "compares its answers with the proved tours."
    )
    return Section("tours", TITLE, _text(rows, compared), tuple(blocks), lead)


def _text(rows: pd.DataFrame, compared: pd.DataFrame) -> str:
    """The section's text.

    It counts the proved tours, and the optima of grids that they refute.
    """
    search = rows[rows["solver"] == EXACT]
    proved = ""
    if len(search):
        proved = (
            f"The search proves {count(search['closes'].sum())} of {count(len(search))} tours "
            "within its limit."
        )
    refuted = ""
    grids = compared[compared["kind"].str.startswith(BEST_OF_GRID)]
    if len(grids):
        refuted = (
            f"Of {count(len(grids))} proved optima of a grid "
            f"{count(grids['verdict'].eq('longer').sum())} are longer than the proved tour, and "
            f"{count(grids['other_order'].sum())} pass the points in another order."
        )
    return sentences(
        "Closed: the search has proved its tour to be shortest, or an engine has solved its own "
        "program to the optimum. An optimum on a grid of headings need not be the shortest tour.",
        proved,
        refuted,
    )


def timed_solvers(rows: pd.DataFrame) -> set[str]:
    """The most asked solver of each engine that proves."""
    asked = of_provers(rows).groupby(["engine", "solver"]).size().rename("asked").reset_index()
    ranked = asked.sort_values("asked", ascending=False, kind="stable")
    return set(ranked.drop_duplicates("engine")["solver"])


def _closed_picture(
    rows: pd.DataFrame, cells: pd.DataFrame, strata: list[str], results: Results
) -> Picture:
    """The picture of questions closed, gaps and times."""
    methods = results.methods.set_index("solver")
    names = [_name(methods.loc[spec], results.settings.get(spec, {})) for spec in methods.index]
    labels = dict(zip(methods.index, distinct(names), strict=True))
    return panels_picture(
        "tours",
        "Above: 5/6 means five of six questions closed, 85 is 85 % of ten or more (no number: a "
        "method that proves nothing). Darker: a larger median gap to the proven lower end of the "
        "shortest length. Below: median times of each engine's most asked method, failures "
        "included; dotted: the limit. One panel per density: the square's side.",
        plot_sizes,
        "Questions closed, gaps and times, by solver, number of points and density",
        cells,
        strata,
        timed_solvers(rows),
        palette_of(results, labels),
        usual_limit(results.rows),
        size="points",
        gaps=GAPS,
    )


def _name(method: pd.Series, settings: dict[str, Any]) -> str:
    """A method's name in the figure, not always distinct.

    It has the engine, and the settings that tell models apart.
    """
    if method["formulation"] == _STRAIGHT_FIRST:
        return f"{settings.get('order', '')} order".strip()
    if method["formulation"] == _DISJUNCTION:
        parts = [method["engine"], _DISJUNCTION, settings.get("emphasis", "")]
    else:
        parts = [method["engine"], settings.get("model", "")]
        if "headings" in settings:
            parts.append(f"K = {settings['headings']}")
        if settings.get("costs") == "bounds":
            parts.append("bounds")
    return ", ".join(filter(None, parts))


def _gap(value: float) -> str:
    if np.isfinite(value):
        return share(value)
    return "no tour"


def _engines(frame: pd.DataFrame) -> Table:
    """The table of medians, a line per solver.

    `frame` is that of `by_engine`, with the columns of `closed_within`.
    """
    shown = (
        SOLVER,
        *columns(kind="cell", closes_text="closed"),
        *columns(kind="cell", in_1_s="in 1 s", in_10_s="in 10 s", in_100_s="in 100 s"),
        *columns(digits(3), nodes="nodes"),
        *columns(lambda mib: count(round(mib)), memory_mib="MiB"),
        *columns(_gap, gap="gap of the answer", own_gap="own gap", bound_gap="gap of the bound"),
        *columns(count, false_bounds="false bounds"),
        *columns(seconds, wall_s="time"),
    )
    caption = (
        "Medians over attempts at the questions that all solvers were asked. Closed in 1, 10 and "
        "100 s: of the questions with as long a limit. Own gap: the gap that the engine leaves in "
        "its own program. The answer's gap is to the proven lower end of the shortest length, the "
        "bound's to its upper end. A false bound lies above that."
    )
    return Table("tours-engines", caption, frame, shown)


def _compared(frame: pd.DataFrame) -> Table:
    """The table of comparisons with proved tours."""
    shown = (
        Column("kind", "answer", kind="text"),
        *columns(kind="cell", refuted_text="refuted", other_order_text="other order"),
        *columns(_gap, excess="longer, median", most="longer, at most"),
    )
    caption = (
        "Answers beside proved tours. Refuted: the proved tour is shorter by more than the "
        "tolerance. Best tour of a grid: an engine has proved that it is the grid's optimum."
    )
    return Table("tours-compared", caption, frame, shown)


TOPIC = Topic("tours", tours_section, TOURS, (General.FOUND,))
