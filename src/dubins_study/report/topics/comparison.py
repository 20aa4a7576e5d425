"""Methods compared: profiles, means and ranks, paired tests."""

from __future__ import annotations

from itertools import chain
from typing import Any, NamedTuple

import pandas as pd

from dubins_study.report.data.attempts import ENOUGH_ASKED, EXACT
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns
from dubins_study.report.elements.content import (
    BENCHMARK,
    Block,
    Picture,
    Section,
    Table,
    Topic,
    panels_picture,
)
from dubins_study.report.elements.formats import count, digits, seconds, sentences, share, some
from dubins_study.report.elements.identity import (
    interval_column,
    interval_keys,
    method_columns,
    with_interval_texts,
)
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.plots import MOST_NAMED, share_curves
from dubins_study.report.statistics.costs import (
    chosen_shift,
    cost_table,
    penalised,
    performance_profile,
    ranking,
    shared_questions,
)
from dubins_study.report.statistics.intervals import (
    geometric_means,
    paired_tests,
    scenario_shares,
)
from dubins_study.report.statistics.methods import (
    Compared,
    compared,
    foremost,
    once,
)


@once
def times(compared: Compared) -> pd.DataFrame:
    """The cost table of whole attempts' times (s).

    Only times of this machine count. See `_costs` for what is left out.
    """
    rows = compared.answerable
    return _costs(compared, rows[~rows["elsewhere"]], "wall_s")


@once
def evaluations(compared: Compared) -> pd.DataFrame:
    """The cost table of function evaluations; see `_costs`."""
    return _costs(compared, compared.answerable, "evaluations")


def _costs(compared: Compared, rows: pd.DataFrame, cost: str) -> pd.DataFrame:
    """The cost table of the engines.

    Only questions that have a path count. Three kinds of methods are left out: the closed form,
    methods that met fewer than `ENOUGH_ASKED` of the questions, and methods whose right answers
    have no cost. Columns are in the order of tables.
    """
    rows = rows[rows["solver"] != EXACT]
    if rows.empty:
        return pd.DataFrame(index=pd.Index([], name="question"))
    table = cost_table(rows, cost, ["question"])
    share_met = table.notna().mean()
    engines = compared.engines.index
    return table[[name for name in engines if name in table and share_met[name] >= ENOUGH_ASKED]]


class Ranks(NamedTuple):
    """Methods in the order of their ranks.

    `shift` (s) is the shift of the means.
    """

    methods: pd.DataFrame
    shift: float


@once
def mean_ranks(compared: Compared) -> Ranks:
    """The methods by their mean times, with ranks.

    A row is a method; the least mean comes first. Columns: those of the method; questions; right
    (share) with its interval; mean (shifted geometric mean with failures at the limit, s) with its
    interval; and the columns of `ranking`.
    """
    shared = shared_questions(times(compared))
    shift = chosen_shift(shared)
    rows = compared.answerable
    rows = rows[rows["question"].isin(shared.index)]
    shares = scenario_shares(rows, by=["solver"], success="right", scenario=["question"])
    names = {"trials": "questions", "share": "right", "low": "right_low", "high": "right_high"}
    right = shares.rename(columns=names)[[*names.values()]]
    at_limit = penalised(shared, compared.limit_s)
    frame = compared.methods.join(right, how="inner").reindex(shared.columns)
    frame = frame.join(compared.bootstrap(at_limit, geometric_means(shift), "mean"))
    frame = frame.join(ranking(shared, compared.limit_s, shift))
    return Ranks(frame.sort_values("mean", kind="stable"), shift)


LEVEL = 0.05


def formulation_tests(table: pd.DataFrame, ranked: pd.DataFrame) -> pd.DataFrame:
    """Paired tests by times within each formulation.

    In each formulation, the best method of `mean_ranks` is tested against each of the others. Rows
    are in that order. Columns: those of `paired_tests`, and formulation.
    """
    pairs: dict[tuple[str, str], Any] = {}
    for name, group in ranked.groupby("formulation", sort=False):
        best = group.index[0]
        pairs |= {(best, rival): name for rival in group.index[1:]}
    return paired_tests(table, pairs).assign(formulation=list(pairs.values()))


def _profiles(table: pd.DataFrame, ranked: pd.DataFrame, palette: Palette) -> Picture:
    """The performance profiles, one panel per formulation.

    `table` is a cost table, and `ranked` the methods of `mean_ranks`. In each panel the
    `MOST_NAMED` methods with the least means or most often right have names.
    """
    profiles = {}
    named = {}
    shared = shared_questions(table)
    order = ranked["formulation"].reindex(table.columns)
    for name in order.dropna().unique():
        group = list(ranked.index[ranked["formulation"] == name])
        # A method is as good as its better place: by its mean time, or by its share right.
        by_mean = ranked["mean"][group].rank(method="first")
        by_share = (-ranked["right"][group]).rank(method="first")
        better_place = pd.concat([by_mean, by_share], axis=1).min(axis=1)
        named[name] = foremost(-better_place, MOST_NAMED)
        profiles[name] = performance_profile(shared[group])
    grey = sum(len(profile.columns) - len(named[name]) for name, profile in profiles.items())
    colours = ""
    if grey:
        colours = (
            f"Named: the {MOST_NAMED} of each panel with the least means or most often right; "
            f"grey: {some(grey, 'method')} more."
        )
    caption = sentences(
        "Performance profiles (Dolan and Moré): the share of questions answered correctly within a "
        "factor of the formulation's fastest right answer. Left: how often a method is the "
        "fastest; right: how often it is right at all. Read only the highest curve as best.",
        colours,
    )
    solvers = chain.from_iterable(named.values())
    names = {solver: str(ranked["short"][solver]) for solver in solvers}
    label = "time / time of the fastest right answer of the formulation"
    alt = "Performance profiles in small panels, one per formulation"
    return panels_picture(
        "comparison-profiles",
        caption,
        share_curves,
        alt,
        profiles,
        names,
        palette,
        label,
        same_x=False,
    )


# Most rivals of a formulation's best method in a table of tests.
_MOST_RIVALS = 6


def rank_table(ranked: pd.DataFrame, shift: float, limit_s: float) -> Table:
    """The table of shares right, means and ranks.

    `ranked` and `shift` are the fields of `Ranks`.
    """
    places = [*map(_place_text, ranked["rank"], ranked["best"], ranked["worst"])]
    shown = (
        *method_columns(ranked),
        *columns(count, questions="questions"),
        interval_column("right", "right"),
        interval_column("mean", "mean time"),
        *columns(kind="cell", place="rank"),
    )
    caption = (
        f"Mean time: shifted geometric mean, shift {seconds(shift)} (the lower quartile of the "
        f"times); a failure costs the limit of {seconds(limit_s)}. The rank is that of the mean. "
        "No rank: it changes at a tenth or ten times the shift, or if failures cost twice or ten "
        "times the limit. 95 % intervals: Wilson's for shares, one trial per question; bootstrap "
        "over scenarios for means."
    )
    frame = with_interval_texts(ranked.assign(place=places), right=share, mean=seconds)
    numbers = interval_keys("right", "mean")
    return Table("comparison-ranks", caption, frame, shown, numbers=numbers, dense=True)


def _place_text(rank: Any, best: Any, worst: Any) -> str:
    """A rank, or `none` and the range of ranks."""
    if rank is pd.NA:
        return f"none\n({best} to {worst})"
    return str(rank)


def test_table(tests: pd.DataFrame, ranked: pd.DataFrame) -> Table:
    """The table of paired tests.

    Each formulation's best method is compared with its nearest rivals, at most `_MOST_RIVALS`.
    """
    names = ranked["short"]
    near = tests.groupby("formulation", sort=False).head(_MOST_RIVALS)
    frame = near.assign(
        solver_name=near["solver"].map(names),
        rival_name=near["rival"].map(names),
        verdict=(near["p_holm"] <= LEVEL).map({True: "one is faster more often", False: "no rank"}),
    ).reset_index(drop=True)
    shown = (
        *columns(kind="text", formulation="formulation", solver_name="method", rival_name="rival"),
        *columns(count, pairs="questions", wins="faster", losses="slower", ties="ties"),
        *columns(digits(2), p="p", p_holm="p, Holm"),
        *columns(kind="text", verdict="verdict"),
    )
    left_out = len(tests) - len(near)
    absent = ""
    if left_out:
        absent = f" {count(left_out)} tests of rivals with larger means are left out."
    caption = (
        "Paired tests (exact sign test, question by question) of each formulation's best method "
        "against its others. A failure loses to every right answer; two failures tie. Holm's "
        f"correction over all {count(len(tests))} tests. No rank: p is above {LEVEL}; do not say "
        f"which is faster. The means, not p, say how much faster.{absent}"
    )
    return Table("comparison-tests", caption, frame, shown, dense=True)


def comparison_section(results: Results) -> Section | None:
    """The section with profiles, ranks and paired tests."""
    attempts = compared(results)
    if attempts is None:
        return None
    table = times(attempts)
    shared = shared_questions(table)
    if shared.empty or len(shared.columns) < 2:
        return None
    ranked, shift = mean_ranks(attempts)
    blocks: list[Block] = [_profiles(table, ranked, Palette.of_page(results))]
    blocks.append(rank_table(ranked, shift, attempts.limit_s))
    tests = formulation_tests(table, ranked)
    if len(tests):
        blocks.append(test_table(tests, ranked))
    unranked = int(ranked["rank"].isna().sum())
    left_out = sum(solver not in table for solver in attempts.engines.index)
    stability = "Every rank stays the same at all shifts and penalties."
    if unranked:
        stability = (
            f"{count(unranked)} of {count(len(ranked))} methods have no rank: it changes with the "
            "shift or with the penalty for failures."
        )
    absent = ""
    if left_out:
        absent = (
            f"{some(left_out, 'method')} take no part: they met less than nine tenths of the "
            "questions, or their right answers have no time."
        )
    text = sentences(
        f"{count(len(shared))} questions with a path, put to {count(len(shared.columns))} methods; "
        "failures stay in every denominator. The closed form is left out.",
        stability,
        absent,
    )
    lead = (
        "See in the profiles which method is fast (high at the left) and which is often right "
        "(high at the right)."
    )
    return Section("comparison", "Comparison of methods", text, tuple(blocks), lead)


TOPIC = Topic("the comparison of methods", comparison_section, BENCHMARK)
