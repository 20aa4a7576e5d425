"""Convex problems: engines of QPs and SOCPs.

They are compared by family of problems and by tolerance, and with and without cvxpy.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.data.attempts import is_true
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import Column, columns, marks
from dubins_study.report.elements.content import (
    Block,
    Picture,
    Section,
    Table,
    Topic,
    panels_picture,
)
from dubins_study.report.elements.formats import ABSENT, count, seconds, sentences, share, some
from dubins_study.report.elements.identity import with_interval, with_share
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.plots import share_curves
from dubins_study.report.elements.style import power
from dubins_study.report.statistics.costs import (
    chosen_shift,
    cost_table,
    penalised,
    performance_profile,
    shifted_geometric_means,
)
from dubins_study.report.statistics.metrics import parse_spec, success
from dubins_study.study.convex.problem import listed

# `socp` is the family of a former set of problems
FAMILIES = {"qp": "QP", "tube": "tube", "time": "fastest drive", "socp": "SOCP"}
_OWN = "own"
_METHOD = ["family", "tolerance", "name"]


def with_parts(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows of frozen problems, with five more columns.

    family: of the problem. interface: `own`, or that through which the engine is called, such as
    cvxpy. name: the engine, with `tuned` for tuned options. right: the check calls the answer
    optimal within the tolerance asked for. kept: primal residual, dual residual and gap of both
    objectives are each within the tolerance.
    """
    families = rows["label"].str.extract(r"^([a-z]+)-\d+-", expand=False).map(FAMILIES)
    rows = rows.assign(family=families)[families.notna()]
    settings = rows["solver"].map(lambda spec: parse_spec(spec)[1])
    interface = settings.map(lambda values: values.get("interface", _OWN))
    tuned = settings.map(lambda values: values.get("options") == "tuned")
    largest = rows[["miss", "dual_residual", "duality_gap"]].max(axis=1, skipna=False)
    return rows.assign(
        interface=interface,
        name=rows["engine"] + np.where(tuned, ", tuned", ""),
        right=success(rows),
        kept=is_true(largest <= rows["tolerance"]),
        false_claim=is_true(rows["false_claim"]),
    )


def time_table(rows: pd.DataFrame) -> pd.DataFrame:
    """The cost table of times (s) at one tolerance.

    A row is a problem, a column an engine's name. A problem that an engine was not asked counts as
    not solved. The engine with the least mean comes first.
    """
    named = rows.drop(columns="solver").rename(columns={"name": "solver"})
    table = cost_table(named, "wall_s", ["label"]).fillna(np.inf)
    means = shifted_geometric_means(penalised(table, named["limit_s"].max()), chosen_shift(table))
    return table[means.sort_values().index]


def by_method(rows: pd.DataFrame) -> pd.DataFrame:
    """Shares right, false claims and times of each method.

    A method is an engine's name at one family and tolerance. Rows are in the order of family,
    tolerance and name. Columns: asked (problems); right (of them) with its share and interval;
    false_claim (problems); floor_s (median); mean_s (shifted geometric mean of times, with failures
    at the limit; NaN where no time is of this machine).
    """
    problems = rows.groupby([*_METHOD, "label"]).agg(
        right=("right", "all"), false_claim=("false_claim", "any"), floor_s=("floor_s", "median")
    )
    groups = problems.groupby(_METHOD)
    frame = groups[["right", "false_claim"]].sum()
    frame = frame.assign(asked=groups.size(), floor_s=groups["floor_s"].median())
    means = {}
    timed = rows[rows["wall_s"].notna()]
    for key, part in timed.groupby(_METHOD[:2]):
        table = penalised(time_table(part), part["limit_s"].max())
        for name, mean in shifted_geometric_means(table, shift_of(rows)).items():
            means[*key, name] = mean
    frame["mean_s"] = pd.Series(means, dtype=np.float64)
    return with_share(frame.reset_index(), "right", frame["right"], frame["asked"])


def shift_of(rows: pd.DataFrame) -> float:
    """The shift of means (s), from right answers."""
    return chosen_shift(rows.loc[rows["right"], "wall_s"])


def convex_section(results: Results) -> Section | None:
    """The section on convex problems.

    It says which engine solves which share of each family at each tolerance, and in which time.
    """
    rows = with_parts(results.rows)
    if rows.empty:
        return None
    direct = rows[rows["interface"] == _OWN]
    methods = by_method(direct)
    false = int(rows["false_claim"].sum())
    denials = rows.loc[rows["false_claim"] & rows["claim"].eq("infeasible"), "name"].value_counts()
    most = ""
    if len(denials):
        most = f" ({denials.index[0]}: {count(denials.iloc[0])})"
    hidden = int((rows["kept"] & rows["verdict"].eq("longer")).sum())
    former = rows.loc[~rows["label"].isin(listed()), "label"].nunique()
    old_problems = ""
    if former:
        old_problems = f"Problems of a former set: {former}."
    text = sentences(
        "An answer is right if the feasible point made from it costs at most the tolerance more "
        "than the proven optimum. Engines are asked for an absolute tolerance and no relative one.",
        f"False claims in {some(len(rows), 'answer')}: {count(false)}. {count(denials.sum())} of "
        f"them say that no point is feasible{most}. The others claim an optimum; the proof and a "
        "residual beyond the tolerance refute it.",
        f"Answers with all three residuals within the tolerance, but further than that from the "
        f"optimum: {count(hidden)}.",
        _through_cvxpy(rows),
        old_problems,
    )
    blocks: list[Block] = [_engines(methods, shift_of(direct))]
    if direct["wall_s"].notna().any():
        blocks = [_profiles(direct, results), *blocks]
    lead = _best_supported(methods)
    return Section("convex", "Convex problems of paths", text, tuple(blocks), lead)


def _best_supported(methods: pd.DataFrame) -> str:
    """A sentence on the best-supported engine of each family.

    It is the engine whose share has the highest lower end, at the least tolerance.
    """
    least = methods["tolerance"].min()
    last = methods[methods["tolerance"] == least].sort_values("right_low", ascending=False)
    parts = []
    for best in last.drop_duplicates("family").itertuples():
        result = with_interval(share, best.right_share, best.right_low, best.right_high)
        parts.append(f"{best.name} on {best.family}, {result}")
    return f"Best supported at the tolerance {power(float(least))}: {'; '.join(parts)}."


def _through_cvxpy(rows: pd.DataFrame) -> str:
    """A sentence on the time that cvxpy adds.

    Times of the same engine at the same problem are compared. The text is empty if there are none.
    """
    right = rows[rows["right"]]
    times = right.groupby(["name", "label", "tolerance", "interface"])["wall_s"].median()
    both = times.unstack("interface").dropna()
    if both.empty or "cvxpy" not in both:
        return ""
    more = seconds((both["cvxpy"] - both[_OWN]).median())
    return f"Through cvxpy the same engine takes {more} longer (median of {len(both)} answers)."


def _profiles(rows: pd.DataFrame, results: Results) -> Picture:
    """The performance profiles at each tolerance.

    QPs and programs with cones have panels of their own.
    """
    timed = rows[rows["wall_s"].notna()]
    kinds = timed["family"].eq(FAMILIES["qp"]).map({True: "QP", False: "with cones"})
    panels = kinds + ", " + timed["tolerance"].map(power)
    order = pd.DataFrame({"kind": kinds, "tolerance": timed["tolerance"], "title": panels})
    order = order.drop_duplicates().sort_values(["kind", "tolerance"], ascending=[True, False])
    profiles = {
        title: performance_profile(time_table(timed[panels == title])) for title in order["title"]
    }
    engines = dict(zip(timed["name"], timed["engine"], strict=True))
    # the hues of the whole page, looked up by the names of this figure
    palette = Palette(Palette.of(results.rows["engine"].unique()).hues, engines)
    caption = (
        "Performance profiles: the share of problems solved right within a factor of the fastest "
        "right answer. Named: the four with the least mean times; grey: others. Read only the "
        "highest curve as best."
    )
    alt = "Performance profiles of QPs and SOCPs at each tolerance"
    return panels_picture(
        "convex",
        caption,
        share_curves,
        alt,
        shares=profiles,
        names={name: name for name in engines},
        palette=palette,
        xlabel="time / time of the fastest right answer",
        ylabel="share of problems",
        same_x=False,
    )


def _engines(methods: pd.DataFrame, shift: float) -> Table:
    """The table of engines, by family.

    A cell has the share right and the mean time at one tolerance. A column counts false claims.
    """
    mean = methods["mean_s"].map(seconds, na_action="ignore").astype(object).fillna(ABSENT)
    floor = np.where(methods["floor_s"] > 0.5 * methods["mean_s"], "*", "")
    most = methods.groupby("family")["asked"].transform("max")
    # ` of 40` behind the share of an engine that was asked fewer problems than others
    sample = (" of " + methods["asked"].map(count)).where(methods["asked"] < most, "")
    cells = methods.assign(at=methods["right_text"] + sample + "\n" + mean + floor)
    groups = cells.groupby(["family", "name"])
    frame = groups.agg(
        false_claim=("false_claim", "sum"), floor_s=("floor_s", "median"), low=("right_low", "mean")
    )
    values = {"at": "at", "right_share": "right", "mean_s": "mean_s"}
    by_tolerance = cells.pivot(index=["family", "name"], columns="tolerance", values=[*values])
    by_tolerance.columns = by_tolerance.columns.map(lambda key: f"{values[key[0]]}_{key[1]:g}")
    frame = frame.join(by_tolerance).reset_index()
    frame = frame.sort_values(["family", "low"], ascending=[True, False], ignore_index=True)
    tolerances = sorted(methods["tolerance"].unique(), reverse=True)
    shown = (
        *columns(kind="text", family="family", name="engine"),
        *(Column(f"at_{t:g}", f"right at {power(float(t))}", kind="cell") for t in tolerances),
        *columns(seconds, floor_s="floor"),
        *columns(count, false_claim="false claims"),
    )
    caption = (
        "Share of problems solved right, its 95 % interval (Wilson), and the mean time. The mean "
        f"is shifted geometric, shift {seconds(shift)} (the lower quartile of all times); failures "
        "and problems not asked count as the limit. Of a number: a sample. *: more than "
        "half of it is the floor, the time of a problem of one variable."
    )
    numbers: list[str] = []
    for t in tolerances:
        numbers += [f"right_{t:g}", f"mean_s_{t:g}"]
    flags = marks(frame, "false_claim")
    return Table("convex-engines", caption, frame, shown, flags, numbers=tuple(numbers), dense=True)


TOPIC = Topic("convex problems", convex_section, "convex")
