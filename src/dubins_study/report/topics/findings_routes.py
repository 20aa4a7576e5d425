"""Findings on routes.

They are the price of a proof, where engines stop, and how times grow.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.data.attempts import ENOUGH_TO_CHOOSE, EXACT, Mask, legs_of
from dubins_study.report.elements.formats import seconds, some
from dubins_study.report.statistics.intervals import geometric_means
from dubins_study.report.statistics.methods import by_support
from dubins_study.report.topics.findings_evidence import (
    ENOUGH,
    Estimate,
    Evidence,
    Finding,
    chosen_share,
    estimate_of,
)
from dubins_study.report.topics.routes import TITLE
from dubins_study.study.arrays import FloatArray

_LONG = 5  # legs, at least, of the routes on which engines stop
_SIZES = 4  # an exponent needs at least this many numbers of legs
_AT_ENDS = 20  # routes of the least and of the largest number of legs, at least
_BEND = 10  # legs; on shorter routes a call costs more than its legs, which bends the line
_RESAMPLES = 20_000
_SEED = 0


def routes_of(evidence: Evidence) -> pd.DataFrame:
    """The attempts at routes that are not open.

    Routes of at least two legs; with a column `legs`.
    """
    return _of_several_legs(evidence.compared.answerable)


def _by_support(evidence: Evidence, rows: pd.DataFrame) -> pd.DataFrame:
    """Shares right of solvers, the best supported first.

    The frame is that of `by_support`. Only engines that met nearly all questions of the rows count.
    """
    engines = rows[rows["solver"].isin(evidence.met_most(rows).index)]
    return by_support(engines, ["solver"])


def _named(evidence: Evidence, solver: str, column: str = "name") -> str:
    """A method's name, and whether the words are given to it.

    `column` is that of `Evidence.methods` with the name.
    """
    name = str(evidence.methods[column][solver])
    if "words" in evidence.knows(solver).split():
        name += " (given the words)"
    return name


def _search(evidence: Evidence) -> pd.DataFrame:
    """The search's attempts at routes.

    Routes of at least two legs, those left open too.
    """
    rows = evidence.compared.rows
    return _of_several_legs(rows[rows["solver"] == EXACT])


def _of_several_legs(rows: pd.DataFrame) -> pd.DataFrame:
    """The attempts at routes of several legs.

    A column `legs` with the number of legs is added.
    """
    legs = legs_of(rows)
    return rows.assign(legs=legs)[legs > 1]


def _closed(rows: pd.DataFrame) -> Mask:
    """A mask of attempts right with a proof.

    The attempts are the search's.
    """
    return rows["right"] & rows["claim"].eq("optimal")


def proof_of_routes(evidence: Evidence) -> Finding | None:
    """How many routes the search proves.

    For each spacing, the search's time is compared with that of an engine without proofs: the
    fastest of those that are right on most routes of this spacing.
    """
    rows = routes_of(evidence)
    search = _search(evidence)
    ranked = _by_support(evidence, rows[~rows["solver"].isin(evidence.provers)])
    names = ranked.index.difference(evidence.at_floor, sort=False)
    if search.empty or names.empty:
        return None
    closed = _closed(search)
    proved = evidence.share_of(closed.astype(float).groupby(search["question"]).mean())
    if proved is None:
        return None
    right = rows[rows["right"]]
    times = right.pivot_table(index="question", columns="solver", values="wall_s", observed=True)
    times = times.reindex(columns=[EXACT, *names])
    label = search.groupby("question")["label"].first()
    ratios: list[Estimate] = []
    parts: list[str] = []
    for spacing in label.unique():
        of_spacing = closed[search["label"] == spacing]
        part = f"with {spacing} it proves {of_spacing.sum()} of {len(of_spacing)}"
        timed = times[label.reindex(times.index) == spacing]
        answered = timed[names].notna().sum()
        both = timed[[EXACT, *names[answered == answered.max()]]].dropna()
        if len(both) >= ENOUGH:
            # geometric means choose the fastest engine and give the ratio
            fastest = np.log(both.drop(columns=EXACT)).mean().idxmin()
            means = geometric_means(0.0)
            each = evidence.compared.bootstrap(both, means, "value", fastest, of=evidence.of)
            ratio = estimate_of(each.loc[[EXACT]], len(both))
            ratios.append(ratio)
            engine = _named(evidence, fastest, "engine")
            part += f", {ratio.text()} times as slow as {engine}"
        parts.append(part)
    if not any(ratio.is_clear(1.0) for ratio in ratios):
        return None
    line = ranked.iloc[0]
    rival = chosen_share(line["share"], int(line["trials"]), len(ranked) * evidence.of)
    most = search["legs"].max()
    longest = search.loc[search["legs"] == most, "wall_s"].median()
    return Finding(
        f"Use the search for a route: within its limit it proves {proved.percent_text()} of the "
        f"routes of 2 to {most} legs.",
        proved,
        f"{some(proved.questions, 'route')}, open ones too: {'; '.join(parts)}. Times are of "
        "routes that both get right, beside the engine right most often. "
        f"With {most} legs it takes {seconds(longest)}. The best supported without a "
        f"proof, {_named(evidence, ranked.index[0])}, is right on {rival.percent_text()} of those "
        "not open",
        TITLE,
    )


def where_engines_stop(evidence: Evidence) -> Finding | None:
    """How often the best engine solves the hardest routes.

    Only routes of at least `_LONG` legs count. The hardest kind of routes (label) is the one on
    which the best-supported engine has the least share. None unless the search proves a larger
    share.
    """
    rows = routes_of(evidence)
    rows = rows[rows["legs"] >= _LONG]
    best_shares: dict[str, Estimate] = {}  # of the best-supported engine of each label
    for label, of_label in rows.groupby("label"):
        ranked = _by_support(evidence, of_label)
        if len(ranked) and ranked["trials"].iloc[0] >= ENOUGH:
            line = ranked.iloc[0]
            several = len(ranked) * rows["label"].nunique() * evidence.of
            best_shares[str(label)] = chosen_share(line["share"], int(line["trials"]), several)
    if not best_shares:
        return None
    label = min(
        best_shares, key=best_shares.__getitem__
    )  # the least share: tuples compare by `value`
    share = best_shares[label]
    chosen = rows[rows["label"] == label]
    ranked = _by_support(evidence, chosen)
    search = _search(evidence)
    proved = _closed(search[(search["label"] == label) & (search["legs"] >= _LONG)])
    if proved.empty or not proved.mean() > share.high:
        return None
    legs = f"{chosen['legs'].min()} to {chosen['legs'].max()} legs"
    named = ""
    if share.questions >= ENOUGH_TO_CHOOSE:
        named = f", {_named(evidence, ranked.index[0])},"
    routes = some(share.questions, "route")
    return Finding(
        f"Do not trust an engine alone with routes of many {label}: the best supported finds the "
        f"shortest on {share.percent_text()}.",
        share,
        f"{routes} of {legs}; the best supported{named} of {some(len(ranked), 'method')}; the "
        f"search proves {proved.sum()} of {len(proved)}",
        TITLE,
    )


def growth(evidence: Evidence) -> Finding | None:
    """How times grow with the number of legs.

    Time is fitted as a power of the number of legs. The finding names the method with the largest
    power and the one with the least. Only methods that are right on most routes of each of at least
    `_SIZES` sizes count, all of one label. An attempt that a limit ended counts as failed, since
    its time is the limit's.
    """
    rows = routes_of(evidence)
    if rows.empty:
        return None
    label = rows.groupby("label")["legs"].max().idxmax()
    rows = rows[(rows["label"] == label) & (rows["legs"] >= _BEND) & ~rows["elsewhere"]]
    largest = rows["legs"].max()
    answered: dict[str, pd.DataFrame] = {}
    usual = evidence.met_most(rows).index
    for solver in [EXACT, *usual.difference(evidence.at_floor, sort=False)]:
        routes = _mastered(rows[rows["solver"] == solver])
        by_size = routes.groupby("legs")["question"].nunique()
        if len(by_size) < _SIZES or by_size.index[-1] < largest:
            continue
        if by_size.iloc[[0, -1]].min() >= _AT_ENDS:
            answered[solver] = routes
    several = len(answered) * evidence.of
    powers = {
        solver: exponent(
            solver_rows["legs"].to_numpy(float), solver_rows["wall_s"].to_numpy(), several
        )
        for solver, solver_rows in answered.items()
    }
    if len(powers) < 2:
        return None
    # estimates are tuples and compare by `value` first
    least = min(powers, key=powers.__getitem__)
    most = max(powers, key=powers.__getitem__)
    power = powers[most]
    if power.questions < ENOUGH or not powers[least].high < power.low:
        return None

    def name_of(solver: str) -> str:
        if solver == EXACT:
            return "the search with a proof"
        return evidence.name(solver)

    def named(solver: str) -> str:
        """A solver's name with two median times.

        The times are at the least and at the largest size.
        """
        times = answered[solver].groupby("legs")["wall_s"].median()
        return f"{name_of(solver)} ({seconds(times.iloc[0])} to {seconds(times.iloc[-1])})"

    def doubled(solver: str) -> str:
        """The factor for twice as many legs, as text."""
        slope = powers[solver]
        return slope._replace(value=2**slope.value, low=2**slope.low, high=2**slope.high).text()

    others = [f"{named(least)} by {doubled(least)}"]
    if EXACT in powers and EXACT not in (least, most):
        others.append(f"{named(EXACT)} by {doubled(EXACT)}")
    return Finding(
        f"Plan for more legs: with {label} twice as many multiply the time of {name_of(most)} by "
        f"{doubled(most)}.",
        power,
        f"{some(power.questions, 'route')} with {label}, of {rows['legs'].min()} to {largest} "
        f"legs, that {named(most)} answers. Its time grows fastest of "
        f"{some(len(powers), 'method')} that are right on most of the longest routes; "
        f"{'; '.join(others)}",
        TITLE,
    )


def _mastered(rows: pd.DataFrame) -> pd.DataFrame:
    """A solver's right answers at the sizes it masters.

    It masters a size if it is right on most routes of that size, before a limit ends the attempt.
    """
    done = rows["right"] & rows["claim"].ne("limit")
    share = done.groupby(rows["legs"]).mean()
    return rows[done & rows["legs"].isin(share.index[share > 0.5])]


def exponent(legs: FloatArray, wall_s: FloatArray, of: int = 1) -> Estimate:
    """The exponent p of time ~ legs^p.

    It is the slope of log time on log legs (least squares). The interval resamples routes within
    each number of legs. If the exponent is chosen as the most extreme of `of`, all their intervals
    hold at once.
    """
    x = np.log(legs)
    y = np.log(wall_s)
    rng = np.random.default_rng(_SEED)
    picks = []
    for size in np.unique(legs):
        places = np.flatnonzero(legs == size)
        picks.append(places[rng.integers(places.size, size=(_RESAMPLES, places.size))])
    sample = np.concatenate(picks, axis=1)
    # the least-squares slope of each resample: sum(dx * y) / sum(dx^2)
    away = x[sample] - x[sample].mean(axis=1, keepdims=True)
    slopes = (away * y[sample]).sum(axis=1) / (away * away).sum(axis=1)
    low, high = np.quantile(slopes, [0.025 / of, 1.0 - 0.025 / of])
    value = float(np.polyfit(x, y, 1)[0])
    return Estimate(value, min(float(low), value), max(float(high), value), legs.size)
