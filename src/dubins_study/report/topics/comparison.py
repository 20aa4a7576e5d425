"""Methods compared: profiles, means and ranks, paired tests."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np
import pandas as pd

from dubins_study.report.data.attempts import ENOUGH_TO_CHOOSE, EXACT, own
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns
from dubins_study.report.elements.content import (
    BENCHMARK,
    Picture,
    Section,
    Table,
    Topic,
    panels_picture,
)
from dubins_study.report.elements.formats import count, digits, seconds, sentences, share, some
from dubins_study.report.elements.identity import (
    best_first,
    interval_column,
    method_table,
    with_interval,
)
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.plots import MOST_NAMED, share_curves
from dubins_study.report.statistics.costs import (
    chosen_shift,
    cost_table,
    penalised,
    performance_profile,
    performance_ratios,
    ranking,
    shared_questions,
    shares_within,
    shifted_geometric_means,
    solved_by_all,
)
from dubins_study.report.statistics.intervals import (
    averages,
    geometric_means,
    paired_tests,
    scenario_shares,
)
from dubins_study.report.statistics.methods import (
    MOST_ENGINES,
    Compared,
    compared,
    foremost,
    once,
)
from dubins_study.study.arrays import FloatArray

# A method that was put to fewer of the questions would shrink what all have in common.
ENOUGH_ASKED = 0.9
# A method that is right on fewer of the questions would empty what all answer.
_ENOUGH_RIGHT = 0.9


@once
def times(compared: Compared) -> pd.DataFrame:
    """The cost table of whole attempts of this machine (s); see `_costs`."""
    rows = compared.answerable
    return _costs(compared, rows[~rows["elsewhere"]], "wall_s")


@once
def evaluations(compared: Compared) -> pd.DataFrame:
    """The cost table of function evaluations; see `_costs`."""
    return _costs(compared, compared.answerable, "evaluations")


def _costs(compared: Compared, rows: pd.DataFrame, cost: str) -> pd.DataFrame:
    """The cost table of the engines at questions with a path, the closed form left out.

    Methods that met fewer than nine tenths of the questions, or of which no right answer says its
    cost, are left out. Columns in the order of tables.
    """
    rows = rows[rows["solver"] != EXACT]
    if rows.empty:
        return pd.DataFrame(index=pd.Index([], name="question"))
    table = cost_table(rows, cost, ["question"])
    met = table.notna().mean()
    kept = [s for s in compared.engines.index if s in table and met[s] >= ENOUGH_ASKED]
    return table[kept]


@once
def mean_ranks(compared: Compared) -> tuple[pd.DataFrame, float, int]:
    """Shares right, means of `times` with failures counted three ways, and ranks.

    First a row per method in the order of the ranks: its columns; questions, right (share) with its
    interval; mean (shifted geometric mean with failures at the limit, s) and par2 (s) with theirs;
    common (shifted geometric mean over what all methods answer that are right on nine tenths, s);
    and the columns of `ranking`. Then the shift (s), and the number of questions behind `common`.
    """
    shared = shared_questions(times(compared))
    shift = chosen_shift(shared)
    rows = compared.answerable
    rows = rows[rows["question"].isin(shared.index)]
    shares = scenario_shares(rows, by=["solver"], success="right", scenario=["question"])
    names = {"trials": "questions", "share": "right", "low": "right_low", "high": "right_high"}
    right = shares.rename(columns=names)[[*names.values()]]
    usual = right.index[right["right"] >= _ENOUGH_RIGHT].intersection(shared.columns)
    common = solved_by_all(shared[usual])
    at_limit, twice = (penalised(shared, compared.limit_s, factor) for factor in (1.0, 2.0))
    frame = compared.methods.join(right, how="inner").reindex(shared.columns)
    frame = frame.join(compared.bootstrap(at_limit, geometric_means(shift), "mean"))
    frame = frame.join(compared.bootstrap(twice, averages, "par2"))
    frame["common"] = shifted_geometric_means(common, shift)
    frame = frame.join(ranking(shared, compared.limit_s, shift))
    return frame.sort_values("mean", kind="stable"), shift, len(common)


LEVEL = 0.05


def shared_tests(table: pd.DataFrame, ranked: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Paired tests by times of methods of `mean_ranks` that share a formulation, or an engine.

    `formulation`: the best method of each against every other. `engine`: its best method of each
    formulation, all pairs. The columns of `paired_tests`, and shared: what the two have in common.
    """
    best = ranked.drop_duplicates(["engine", "formulation"])
    pairs = {
        "formulation": {
            (group.index[0], rival): name
            for name, group in ranked.groupby("formulation", sort=False)
            for rival in group.index[1:]
        },
        "engine": {
            pair: name
            for name, group in best.groupby("engine", sort=False)
            for pair in combinations(group.index, 2)
        },
    }
    return {
        shared: paired_tests(table, each).assign(shared=list(each.values()))
        for shared, each in pairs.items()
    }


def pictures(
    attempts: Compared, table: pd.DataFrame, ranked: pd.DataFrame, palette: Palette
) -> Iterator[Picture]:
    """Profiles by formulation in times, and of the best methods in evaluations."""
    if (ranked["formulation"].value_counts() > 1).any():
        yield _profiles(table, ranked, palette)
    counted = ranked[ranked.index.isin(evaluations(attempts).columns)]
    if len(counted):
        yield _evaluations(attempts, _drawn(counted), palette)


def _drawn(ranked: pd.DataFrame) -> list[str]:
    """Plug-ins' solvers, and the best method of each formulation."""
    best = ranked.drop_duplicates("formulation").index
    return list(dict.fromkeys([*own(ranked.index), *best]))[:MOST_ENGINES]


def _profiles(table: pd.DataFrame, ranked: pd.DataFrame, palette: Palette) -> Picture:
    profiles, named = {}, {}
    shared = shared_questions(table)
    order = ranked["formulation"].reindex(table.columns)
    for name in order.dropna().unique():
        group = list(ranked.index[ranked["formulation"] == name])
        if len(group) < 2:
            continue
        best = pd.concat([ranked["mean"][group].rank(), -ranked["right"][group]], axis=1)
        named[name] = foremost(-best.rank(method="first").min(axis=1), MOST_NAMED)
        ratios = performance_ratios(shared[group]).to_numpy()
        largest = np.max(ratios[np.isfinite(ratios)], initial=1.0)
        profiles[name] = performance_profile(
            shared[group], np.geomspace(1.0, max(largest, 2.0), 120)
        )
    grey = sum(len(profile.columns) - len(named[name]) for name, profile in profiles.items())
    caption = sentences(
        "Performance profiles, formulation by formulation: the share of questions answered "
        "correctly within a factor of the formulation's fastest right answer (Dolan and Moré). At "
        "the left: how often a method is the fastest; at the right: how often it is right at all. "
        "Read only the highest curve as best. Formulations with a single method are in the "
        "figures below.",
        f"Named: in each the {MOST_NAMED} with the least means or most often right; grey: "
        f"{some(grey, 'method')} more."
        if grey
        else "",
    )
    names = {solver: str(ranked["short"][solver]) for group in named.values() for solver in group}
    label = "time / time of the fastest right answer of the formulation"
    alt = "Performance profiles in small panels, one per formulation"
    data = profiles, names, palette, label
    return panels_picture("comparison-profiles", caption, share_curves, alt, *data, same_x=False)


def _evaluations(attempts: Compared, solvers: list[str], palette: Palette) -> Picture:
    table = evaluations(attempts)[solvers]
    shares = shares_within(table, _points(table))
    caption = (
        "Data profile: the share of questions that a method answers correctly within a number of "
        "function evaluations, restarts and all subproblems included; the best method of each "
        "formulation whose engine counts them. One evaluation costs more in some formulations "
        "than in others."
    )
    alt = "Data profiles in evaluations"
    names = {solver: palette.label(solver) for solver in map(str, shares.columns)}
    data = {"": shares}, names, palette, "function evaluations"
    return panels_picture("comparison-evaluations", caption, share_curves, alt, *data)


def _points(table: pd.DataFrame) -> FloatArray:
    """Points of a logarithmic axis over the finite values of a table."""
    values = table.to_numpy(dtype=np.float64)
    finite = values[np.isfinite(values) & (values > 0)]
    low, high = (finite.min(), finite.max()) if finite.size else (1.0, 10.0)
    return np.geomspace(low, max(1.2 * high, 2 * low), 160)


# Rivals of a formulation's or an engine's best method that a table of tests shows.
_MOST_RIVALS = 6


def rank_table(ranked: pd.DataFrame, shift: float, common: int, limit_s: float) -> Table:
    """Shares right, means and ranks."""
    places = zip(ranked["rank"], ranked["best"], ranked["worst"], strict=True)
    frame = ranked.assign(
        place=[str(rank) if rank is not pd.NA else f"none\n({a} to {b})" for rank, a, b in places]
    )
    shown = (
        *columns(count, questions="questions"),
        interval_column("right", "right"),
        interval_column("mean", "mean time"),
        *columns(kind="cell", place="rank"),
        *columns(count, rank_tenth="shift / 10", rank_tenfold="shift × 10"),
        interval_column("par2", "PAR-2"),
        *columns(seconds, common="mean over common"),
    )
    caption = (
        f"Mean time: shifted geometric mean, shift {seconds(shift)} (the lower quartile of the "
        f"times), a failure costs the limit of {seconds(limit_s)}. The rank is that of the mean; "
        "none if it changes at a tenth or ten times the shift, or if failures cost twice or ten "
        "times the limit. PAR-2: arithmetic mean, a failure costs twice the limit. Over common: "
        f"the shifted mean over the {count(common)} questions that all methods answer which are "
        "right on at least nine tenths of them. 95 % intervals: Wilson's for shares, for as many "
        "trials as there are questions, and bootstrap over scenarios for means."
    )
    shows = {"right": share, "mean": seconds, "par2": seconds}
    return method_table("comparison-ranks", caption, frame, shown, **shows)


def test_table(tests: pd.DataFrame, ranked: pd.DataFrame, shared: str) -> Table:
    """Paired tests of methods that share a formulation or an engine; the nearest rivals."""
    names = ranked["short"] if shared == "formulation" else ranked["name"]
    near = tests.groupby(["shared", "solver"], sort=False).head(_MOST_RIVALS)
    frame = near.assign(
        solver_name=near["solver"].map(names),
        rival_name=near["rival"].map(names),
        verdict=(near["p_holm"] <= LEVEL).map({True: "they differ", False: "no rank"}),
    ).reset_index(drop=True)
    shown = (
        *columns(kind="text", shared=shared, solver_name="method", rival_name="rival"),
        *columns(count, pairs="questions", wins="faster", losses="slower", ties="ties"),
        *columns(digits(2), p="p", p_holm="p, Holm"),
        *columns(kind="text", verdict="verdict"),
    )
    left_out = len(tests) - len(near)
    rest = f" {count(left_out)} tests of rivals with larger means are left out." if left_out else ""
    what = (
        "the best method of each formulation against the others of the same formulation"
        if shared == "formulation"
        else "the best methods of one engine on two formulations"
    )
    caption = (
        f"Paired tests of {what}: Wilcoxon's signed ranks of the ratio of times, question by "
        "question; a failure loses to every right answer, two failures tie. Holm's correction over "
        f"all {count(len(tests))} tests. No rank: p above {LEVEL}; do not say which is "
        f"faster.{rest}"
    )
    return Table(f"comparison-tests-{shared}", caption, frame, shown, dense=True)


def comparison_section(results: Results) -> Section | None:
    """Profiles, means and ranks, and paired tests."""
    attempts = compared(results)
    if attempts is None:
        return None
    table = times(attempts)
    shared = shared_questions(table)
    if shared.empty or len(shared.columns) < 2:
        return None
    ranked, shift, common = mean_ranks(attempts)
    palette = Palette.of_page(results)
    blocks: list[Picture | Table] = [*pictures(attempts, table, ranked, palette)]
    ranks = rank_table(ranked, shift, common, attempts.limit_s)
    best = {*own(ranked.index), *ranked.drop_duplicates("formulation").index}
    which = "Of each formulation the method with the least mean."
    blocks += best_first(ranks, ranked.index, best, which)
    tests = shared_tests(table, ranked).items()
    blocks += [test_table(each, ranked, shared) for shared, each in tests if len(each)]
    unranked = int(ranked["rank"].isna().sum())
    left_out = sum(solver not in table for solver in attempts.engines.index)
    text = sentences(
        f"{count(len(shared))} questions with a path, put to {count(len(shared.columns))} methods; "
        "failures stay in every denominator. The closed form is left out.",
        _first(ranked),
        f"{count(unranked)} of {count(len(ranked))} methods have no rank: it changes with the "
        "shift or with the penalty for failures."
        if unranked
        else "Every rank stays at any shift and penalty tried.",
        f"{some(left_out, 'method')} that met less than nine tenths of the questions, or whose "
        "right answers have no time, take no part."
        if left_out
        else "",
    )
    lead = (
        "See in the profiles which method is fast (high at the left) and which is right at all "
        "(high at the right)."
    )
    return Section("comparison", "Comparison of methods", text, tuple(blocks), lead)


def _first(ranked: pd.DataFrame) -> str:
    """The method with the least mean; empty of too few questions."""
    first = ranked.to_dict("records")[0]
    if first["questions"] < ENOUGH_TO_CHOOSE:
        return ""
    mean = with_interval(seconds, first["mean"], first["mean_low"], first["mean_high"])
    right = with_interval(share, first["right"], first["right_low"], first["right_high"])
    return (
        f"The least mean time over {count(first['questions'])} questions has {first['name']}: "
        f"{mean}, right on {right} of them."
    )


TOPIC = Topic("the comparison of methods", comparison_section, BENCHMARK)
