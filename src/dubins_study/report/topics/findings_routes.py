"""What the study found of routes: what a proof costs, where engines stop, how times grow."""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.data.attempts import ENOUGH_TO_CHOOSE, EXACT, legs_of
from dubins_study.report.elements.formats import digits, seconds, some
from dubins_study.report.statistics.intervals import geometric_means, scenario_shares
from dubins_study.report.topics.findings_evidence import (
    ENOUGH,
    PERCENT,
    TIMES,
    Estimate,
    Evidence,
    Finding,
    chosen_share,
    estimate_of,
)
from dubins_study.report.topics.routes import TITLE
from dubins_study.study.arrays import FloatArray

_LONG = 5  # legs from which engines are asked where they stop
_SIZES = 4  # numbers of legs that an exponent is of, at least
_BEND = 10  # legs; on shorter routes a call costs more than its legs, which bends the line
_RESAMPLES, _SEED = 2000, 0
# Rows of an engine that began before this time (UTC) say nothing of how its time grows: our adapter
# gave it less than it takes. Of Uno: whole matrices, 97 % of its time at 200 legs.
_GIVEN_LESS_UNTIL = {"Uno filterSQP": "2026-11-27T12"}


def routes_of(evidence: Evidence) -> pd.DataFrame:
    """The attempts at routes of at least two legs, with a column legs."""
    rows = evidence.compared.answerable
    legs = legs_of(rows)
    return rows.assign(legs=legs)[legs > 1]


def _surest(evidence: Evidence, rows: pd.DataFrame) -> pd.DataFrame:
    """Engines that met nearly all questions, the most surely right first: `scenario_shares`."""
    engines = rows[rows["solver"].isin(evidence.usual.index)]
    if engines.empty:
        return pd.DataFrame()
    shares = scenario_shares(engines, by=["solver"], success="right", scenario=["question"])
    time = engines.groupby("solver", observed=True)["wall_s"].median()
    shares = shares.assign(wall_s=time.reindex(shares.index))
    return shares.sort_values(["low", "wall_s"], ascending=[False, True])


def _named(evidence: Evidence, *solvers: str) -> str:
    """The names of engines' methods, and whether the words are known to all of them."""
    given = all("words" in evidence.knows(solver).split() for solver in solvers)
    names = " and ".join(map(evidence.name, solvers))
    return names + (" (given the words)" if given else "")


def proof_of_routes(evidence: Evidence) -> Finding | None:
    """How many routes the search proves, and its time beside the surest engine without proofs.

    Of several engines that are as sure the fastest counts, spacing by spacing.
    """
    rows = routes_of(evidence)
    own, others = rows[rows["solver"] == EXACT], rows[~rows["solver"].isin(evidence.provers)]
    surest = _surest(evidence, others)
    if own.empty or surest.empty:
        return None
    line = surest.iloc[0]
    names = [str(solver) for solver in surest.index[surest["low"] == line["low"]]]
    closed = own["right"] & own["claim"].eq("optimal")
    proved = evidence.share_of(closed.astype(float).groupby(own["question"]).mean())
    right = rows[rows["right"] & rows["solver"].isin([EXACT, *names])]
    times = right.pivot_table(index="question", columns="solver", values="wall_s", observed=True)
    both = times.reindex(columns=[EXACT, *names]).dropna()
    if proved is None or len(both) < ENOUGH_TO_CHOOSE or {*names} & {*evidence.at_floor}:
        return None
    label = own.groupby("question")["label"].first().reindex(both.index)
    ratios = [
        (name, len(part), *_against_fastest(evidence, part, names))
        for name, part in both.groupby(label, sort=False)
        if len(part) >= ENOUGH
    ]
    if not any(ratio.is_clear(1.0) for *_, ratio, _ in ratios):
        return None
    engines = evidence.methods["engine"][names]
    short = engines if engines.is_unique else evidence.methods["name"]
    compared = " and ".join(
        f"{ratio.text()} times the time of {short[fastest]} on {some(n, 'route')} with {label}"
        for label, n, ratio, fastest in ratios
    )
    rival = chosen_share(line["share"], int(line["trials"]), len(surest))
    longest = own[own["legs"] == own["legs"].max()]
    several = len(names) > 1
    medians = ", ".join(seconds(value) for value in both.median())
    return Finding(
        "Ask for a proof of a route, not only of a leg: the search with a proof closes "
        f"{proved.percent_text()} of the routes of 2 to {own['legs'].max()} legs within its limit, "
        f"those of {own['legs'].max()} in {seconds(longest['wall_s'].median())}. Of the engines "
        f"{_named(evidence, *names)} {'find' if several else 'finds'} most, "
        f"{rival.percent_text()}, and {'prove' if several else 'proves'} none; where "
        f"all are right the search takes {compared} (geometric means).",
        ratios[0][2],
        TIMES,
        f"{some(proved.questions, 'route')}; {len(both)} that all of them answer, medians "
        f"{medians}",
        TITLE,
    )


def _against_fastest(
    evidence: Evidence, both: pd.DataFrame, names: list[str]
) -> tuple[Estimate, str]:
    """The search's time over that of the fastest of several solvers, and which that is.

    Times are compared, and the ratio is had, by geometric means.
    """
    name = str(np.log(both[names]).mean().idxmin())
    ratios = evidence.compared.bootstrap(both, geometric_means(0.0), "value", name).loc[[EXACT]]
    return estimate_of(ratios, "value", len(both)), name


def where_engines_stop(evidence: Evidence) -> Finding | None:
    """Of the kind of routes that is hardest to engines, the share that the surest finds."""
    rows = routes_of(evidence)
    rows = rows[rows["legs"] >= _LONG]
    found: list[tuple[Estimate, str, str, pd.DataFrame]] = []
    for label, of_label in rows.groupby("label"):
        surest = _surest(evidence, of_label)
        if len(surest) and surest["trials"].iloc[0] >= ENOUGH:
            line = surest.iloc[0]
            share = chosen_share(line["share"], int(line["trials"]), len(surest))
            found.append((share, str(label), str(surest.index[0]), of_label))
    if not found:
        return None
    share, label, name, chosen = min(found)
    own = chosen[chosen["solver"] == EXACT]
    proved = own["right"] & own["claim"].eq("optimal")
    if own.empty or not proved.mean() > share.high / 100:
        return None
    legs = f"{chosen['legs'].min()} to {chosen['legs'].max()} legs"
    named = f", {_named(evidence, name)}," if share.questions >= ENOUGH_TO_CHOOSE else ""
    return Finding(
        f"Do not trust any engine alone with routes of many {label}: of {legs} the surest{named} "
        f"finds the shortest on {share.percent_text()} of {some(share.questions, 'route')}; the "
        f"search proves {int(proved.sum())} of {len(own)}.",
        share,
        PERCENT,
        f"{some(share.questions, 'route')} of {legs}, the surest of "
        f"{some(len(_surest(evidence, chosen)), 'method')}",
        TITLE,
    )


def growth(evidence: Evidence) -> Finding | None:
    """With which power of the number of legs times grow: the least and the largest.

    Of methods that are right on most routes of each of at least four sizes, all of one label. An
    attempt that a limit ended counts as failed: its time is the limit's.
    """
    rows = routes_of(evidence)
    since = rows["engine"].astype(str).map(_GIVEN_LESS_UNTIL).fillna("")
    rows = rows[rows["started"].astype(str) >= since]
    if rows.empty:
        return None
    label = rows.groupby("label")["legs"].max().idxmax()
    rows = rows[(rows["label"] == label) & (rows["legs"] >= _BEND) & ~rows["elsewhere"]]
    solvers = [EXACT, *(s for s in evidence.usual.index if s not in evidence.at_floor)]
    powers: list[tuple[Estimate, str]] = []
    chosen: dict[str, pd.DataFrame] = {}
    for solver in solvers:
        mine = rows[rows["solver"] == solver]
        done = mine["right"] & mine["claim"].ne("limit")
        share = done.groupby(mine["legs"]).mean()
        sizes = share.index[share > 0.5]
        if len(sizes) >= _SIZES and sizes.max() == rows["legs"].max():
            chosen[solver] = mine[done & mine["legs"].isin(sizes)]
    for solver, mine in chosen.items():
        estimate = exponent(mine["legs"].to_numpy(float), mine["wall_s"].to_numpy(), len(chosen))
        powers.append((estimate, solver))
    if len(powers) < 2:
        return None
    least, most = min(powers), max(powers)
    own = next((power for power, solver in powers if solver == EXACT), None)
    if most[0].questions < ENOUGH or not least[0].high < most[0].low:
        return None

    def named(solver: str) -> str:
        mine = chosen[solver].groupby("legs")["wall_s"].median()
        name = "the search with a proof" if solver == EXACT else evidence.name(solver)
        ends = f"{seconds(mine.iloc[0])} to {seconds(mine.iloc[-1])}"
        return f"{name} ({ends})"

    shown = digits(2)
    between = EXACT not in (least[1], most[1])
    proof = f"; that of {named(EXACT)} to {own.text(shown)}" if own and between else ""
    largest = rows[rows["legs"] == rows["legs"].max()]
    return Finding(
        f"Plan for size by the power of the legs, not by one time: with {label}, from "
        f"{rows['legs'].min()} to {rows['legs'].max()} legs, the time of "
        f"{named(most[1])} grows as the legs to the power {most[0].text(shown)}, that of "
        f"{named(least[1])} to the power {least[0].text(shown)}{proof}.",
        most[0],
        "power",
        f"{some(most[0].questions, 'route')} that the first one answers; "
        f"{some(len(powers), 'method')} still right on most of the "
        f"{some(largest['question'].nunique(), 'route')} of {largest['legs'].max()} legs",
        TITLE,
    )


def exponent(legs: FloatArray, wall_s: FloatArray, of: int = 1) -> Estimate:
    """The slope of log time on log legs (least squares), with its interval over routes.

    Routes are resampled within each number of legs. If it is the most extreme of several, the
    interval is that of all at once.
    """
    x, y = np.log(legs), np.log(wall_s)
    sizes = [np.flatnonzero(legs == size) for size in np.unique(legs)]
    rng = np.random.default_rng(_SEED)
    picks = np.concatenate(
        [size[rng.integers(size.size, size=(_RESAMPLES, size.size))] for size in sizes], axis=1
    )
    xs, ys = x[picks], y[picks]
    away = xs - xs.mean(axis=1, keepdims=True)
    slopes = (away * ys).sum(axis=1) / (away * away).sum(axis=1)
    low, high = np.quantile(slopes, [0.025 / of, 1.0 - 0.025 / of])
    value = float(np.polyfit(x, y, 1)[0])
    return Estimate(value, min(float(low), value), max(float(high), value), legs.size)
