"""Convex problems: engines of QPs and SOCPs by family and accuracy, and what cvxpy adds."""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.data.attempts import is_true
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import Column, columns, marks
from dubins_study.report.elements.content import Picture, Section, Table, Topic, panels_picture
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

# In the order of tables. The last one is of a former set of problems.
FAMILIES = {"qp": "QP", "tube": "tube", "time": "fastest drive", "socp": "SOCP"}
_OWN = "own"
_SAMPLED = 20  # problems of a family; of fewer no sentence names an engine


def with_parts(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows of frozen problems with columns that name the parts of their labels and specs.

    family, size (about the number of variables), interface, method (the spec without its
    tolerance), name (of the engine, with what is not usual), right and kept. Right: the check calls
    the answer optimal within the tolerance asked for. Kept: primal residual, dual residual and gap
    of both objectives are each within it.
    """
    parts = rows["label"].str.extract(r"^(?P<family>[a-z]+)-(?P<size>\d+)-")
    rows = rows[parts["family"].isin(FAMILIES)]
    settings = rows["solver"].map(lambda spec: parse_spec(spec)[1])
    tuned = settings.map(lambda values: values.get("options") == "tuned")
    interface = settings.map(lambda values: values.get("interface", _OWN))
    largest = rows[["miss", "dual_residual", "duality_gap"]].max(axis=1, skipna=False)
    names = rows["engine"] + np.where(tuned, ", tuned", "")
    return rows.assign(
        family=parts["family"],
        size=pd.to_numeric(parts["size"]),
        interface=interface,
        name=names + np.where(interface == _OWN, "", ", cvxpy"),
        right=success(rows),
        kept=is_true(largest <= rows["tolerance"]),
    )


def time_table(rows: pd.DataFrame) -> pd.DataFrame:
    """The cost table of one family and tolerance (s): a row a problem, a column an engine's name.

    A problem that an engine was not asked counts as not solved. Engines come by their means.
    """
    named = rows.drop(columns="solver").rename(columns={"name": "solver"})
    table = cost_table(named, "wall_s", ["label"]).fillna(np.inf)
    limit = float(rows["limit_s"].max())
    means = shifted_geometric_means(penalised(table, limit), chosen_shift(table))
    return table[means.sort_values().index]


def by_method(rows: pd.DataFrame) -> pd.DataFrame:
    """One row per family, tolerance and engine's name, the surest first.

    Columns: asked and right (problems) with its share and interval, kept, false_claim (attempts),
    floor_s (median), mean_s (shifted geometric mean of times, failures at the limit).
    """
    keys = ["family", "tolerance", "name"]
    each = rows.assign(false_claim=is_true(rows["false_claim"])).groupby([*keys, "label"])
    problems = each.agg(right=("right", "all"), kept=("kept", "all")).groupby(keys)
    frame = problems.sum().assign(asked=problems.size())
    groups = rows.groupby(keys)
    frame["false_claim"] = each["false_claim"].sum().groupby(keys).sum()
    frame["floor_s"] = groups["floor_s"].median()
    frame["mean_s"] = np.nan
    shift = chosen_shift(rows.loc[rows["right"], "wall_s"])
    for (family, tolerance), part in rows.groupby(["family", "tolerance"]):
        if part["wall_s"].notna().any():
            table = penalised(time_table(part), float(part["limit_s"].max()))
            for name, mean in shifted_geometric_means(table, shift).items():
                frame.loc[(family, tolerance, name), "mean_s"] = mean
    frame = with_share(frame.reset_index(), "right", frame["right"], frame["asked"])
    order = ["family", "tolerance", "right_low", "mean_s"]
    return frame.sort_values(order, ascending=[True, True, False, True], kind="stable")


def convex_section(results: Results) -> Section | None:
    """Which engine solves which share of each family at each tolerance, and in which time."""
    rows = with_parts(results.rows)
    if rows.empty:
        return None
    own = rows[rows["interface"] == _OWN]
    methods = by_method(own)
    false = int(is_true(rows["false_claim"]).sum())
    hidden = int((rows["kept"] & rows["verdict"].eq("longer")).sum())
    former = rows.loc[~rows["label"].isin(listed()), "label"].nunique()
    text = sentences(
        "An answer is right if the feasible point made from it costs at most the tolerance more "
        "than the proven optimum. Engines are asked for an absolute tolerance and no relative one.",
        f"{some(false, 'claim')} of {count(len(rows))} answers {'is' if false == 1 else 'are'} "
        "false: of an optimum, by the proof and by a residual beyond the tolerance; or that no "
        "point is feasible.",
        f"{some(hidden, 'answer')} {'keeps' if hidden == 1 else 'keep'} all three residuals within "
        f"the tolerance and {'is' if hidden == 1 else 'are'} further than that from the optimum.",
        _through_cvxpy(rows),
        f"{some(former, 'problem')} {'is' if former == 1 else 'are'} of a former set."
        if former
        else "",
    )
    blocks: list[Picture | Table] = [_engines(methods, own)]
    if own["wall_s"].notna().any():
        blocks = [_profiles(own, results), *blocks]
    return Section("convex", "Convex problems of paths", text, tuple(blocks), _surest(methods))


def _surest(methods: pd.DataFrame) -> str:
    """The surest engine of each family at the least tolerance that was asked."""
    least = methods[methods["tolerance"] == methods["tolerance"].min()]
    least = least[least["asked"] >= _SAMPLED]
    parts = []
    for family, title in FAMILIES.items():
        group = least[least["family"] == family]
        if len(group):
            best = group.iloc[0]
            found = with_interval(share, best["right_share"], best["right_low"], best["right_high"])
            parts.append(f"{best['name']} for the family {title}: {found}")
    if not parts:
        return ""
    asked = power(float(least["tolerance"].iloc[0]))
    return f"Most surely right at the tolerance {asked} are {'; '.join(parts)}."


def _through_cvxpy(rows: pd.DataFrame) -> str:
    """How much longer the same engines take through cvxpy for the same problems."""
    usual = rows[~rows["name"].str.contains("tuned") & rows["right"]]
    keys = ["engine", "label", "tolerance", "interface"]
    times = usual.groupby(keys)["wall_s"].median().unstack("interface")
    if "cvxpy" not in times:
        return ""
    more = (times["cvxpy"] - times[_OWN]).dropna()
    if more.empty:
        return ""
    problems = more.index.get_level_values("label").nunique()
    return (
        f"Through cvxpy the same engine takes {seconds(more.median())} longer (median of "
        f"{some(problems, 'problem')}, right both ways)."
    )


def _profiles(rows: pd.DataFrame, results: Results) -> Picture:
    """Performance profiles of QPs and of programs with cones, at each tolerance."""
    profiles = {}
    kinds = np.where(rows["family"] == "qp", "QP", "with cones")
    for kind in sorted(set(kinds)):
        for tolerance in sorted(rows["tolerance"].unique(), reverse=True):
            part = rows[(kinds == kind) & (rows["tolerance"] == tolerance)]
            if part["wall_s"].notna().any():
                title = f"{kind}, {power(float(tolerance))}"
                profiles[title] = performance_profile(time_table(part))
    engines = dict(zip(rows["name"], rows["engine"], strict=True))
    palette = Palette(Palette.of(results.rows["engine"].unique()).hues, engines)
    caption = (
        "Performance profiles: the share of problems solved right within a factor of the fastest "
        "right answer. Named: the four with the least mean times; grey: others. Read only the "
        "highest curve as best."
    )
    alt = "Performance profiles of QPs and SOCPs at each tolerance"
    label = "time / time of the fastest right answer"
    data = profiles, {name: name for name in engines}, palette, label, "share of problems"
    return panels_picture("convex", caption, share_curves, alt, *data, same_x=False)


def _engines(methods: pd.DataFrame, rows: pd.DataFrame) -> Table:
    """By family and engine: shares right and mean times at each tolerance, and false claims."""
    tolerances = sorted(methods["tolerance"].unique(), reverse=True)
    floors = methods["floor_s"] > 0.5 * methods["mean_s"]
    mean = methods["mean_s"].map(lambda s: ABSENT if np.isnan(s) else seconds(s))
    cells = methods.assign(cell=methods["right_text"] + "\n" + mean + np.where(floors, "*", ""))
    keys = ["family", "name"]
    groups = cells.groupby(keys, sort=False)
    frame = groups.agg(
        asked=("asked", "max"),
        false_claim=("false_claim", "sum"),
        floor_s=("floor_s", "median"),
        low=("right_low", "mean"),
    )
    for tolerance in tolerances:
        part = cells[cells["tolerance"] == tolerance].set_index(keys)
        frame[f"at_{tolerance:g}"] = part["cell"]
        frame[f"right_{tolerance:g}"] = part["right_share"]
        frame[f"mean_s_{tolerance:g}"] = part["mean_s"]
    frame = frame.reset_index()
    place = frame["family"].map(list(FAMILIES).index)
    frame = frame.assign(place=place, family=frame["family"].map(FAMILIES))
    frame = frame.sort_values(["place", "low"], ascending=[True, False], ignore_index=True)
    shown = (
        *columns(kind="text", family="family", name="engine"),
        *columns(count, asked="problems"),
        *(Column(f"at_{t:g}", f"right at {power(float(t))}", kind="cell") for t in tolerances),
        *columns(seconds, floor_s="floor"),
        *columns(count, false_claim="false claims"),
    )
    shift = chosen_shift(rows.loc[rows["right"], "wall_s"])
    caption = (
        "Share of problems solved right, its 95 % interval (Wilson), and the mean time: shifted "
        f"geometric, shift {seconds(shift)} (the lower quartile of all times), failures at the "
        "limit. *: the floor, the time of a problem of one variable, is more than half of it."
    )
    numbers = tuple(f"{name}_{t:g}" for t in tolerances for name in ("right", "mean_s"))
    flags = marks(frame, "false_claim")
    return Table("convex-engines", caption, frame, shown, flags, numbers=numbers, dense=True)


TOPIC = Topic("convex problems", convex_section, "convex")
