"""The first section: every solver's attempts in one table and one chart."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from dubins_study.report.data.attempts import SUCCESSES, Attempts
from dubins_study.report.data.results import Results
from dubins_study.report.page.content import (
    Column,
    Picture,
    Section,
    Table,
    count,
    digits,
    seconds,
    share,
    slug,
)
from dubins_study.report.page.style import HALF, WIDE, legend_lines, name_of, new_figure
from dubins_study.report.statistics.metrics import (
    STUDIES,
    failures,
    gap_quantiles,
    gap_shares,
    summary,
)
from dubins_study.report.topics.summary.figures import plot_gap_profile, plot_verdicts

_MOST_FAILURES = 25


def attempts(results: Results) -> Attempts:
    """The attempts that count here: all but those of the studies, if there are others."""
    others = results.attempts.without(STUDIES)
    return others if others.experiments else results.attempts


def some(number: int, noun: str) -> str:
    """A number and what is counted, in the singular or the plural."""
    return f"{count(number)} {noun}{'' if number == 1 else 's'}"


def summary_section(results: Results) -> Section | None:
    """Attempts, verdicts and times, solver by solver."""
    found = attempts(results)
    frame = summary(found.verdicts())
    caption = (
        "What the check found of every attempt. Success is optimal or none exists, as a share of "
        "all attempts, those that failed included. A false claim says more than the check finds; "
        "a wrong basin is a longer path that turns by another angle. "
        "Not returned: timed out, crashed, raised, unsupported or unavailable."
        f"{found.precision}"
    )
    asked = [run.name for run in results.folders if run.name in found.experiments]
    asked = list(dict.fromkeys(asked))
    right = frame[list(SUCCESSES)].to_numpy().sum() / found.count
    text = (
        f"{some(found.count, 'attempt')} by {some(len(frame), 'solver')} in the "
        f"{'experiment' if len(asked) == 1 else 'experiments'} {', '.join(asked)}; "
        f"success: {share(right)}. No number here rests on a solver's own word: each path "
        "is driven again from its controls and judged against the closed form."
    )
    table = Table("summary", caption, frame, _summary_columns(), _bad_counts(frame))
    return Section("summary", "Summary", text, (table,))


def _summary_columns() -> tuple[Column, ...]:
    counts = ("attempts", "optimal", "none exists", "longer", "misses", "none")
    return (
        Column("solver", "solver", kind="code"),
        *(Column(key, key, count) for key in counts),
        Column("success", "success", share),
        Column("false_claims", "false claims", count),
        Column("wrong_basins", "wrong basins", count),
        Column("not_returned", "not returned", count),
        Column("wall_s", "median time", seconds),
    )


def _bad_counts(frame: pd.DataFrame) -> dict[tuple[int, str], str]:
    wrong = ("misses", "none", "false_claims", "not_returned")
    rows = frame.to_dict("records")
    return {(i, key): "bad" for i, row in enumerate(rows) for key in wrong if row[key]}


def success_section(results: Results) -> Section | None:
    """Verdicts, gap profiles, gap quantiles per region, and what failed."""
    found = attempts(results)
    each = {name: found.only([name]) for name in found.experiments}
    blocks: list[Picture | Table] = [_verdict_picture(found)]
    if len(each) > 1:
        blocks.append(_experiment_table(each))
    quantiles = gap_quantiles(found.gap_quantiles())
    if len(quantiles):
        allowed = _tolerances(results)
        blocks += [_profile_picture(name, own, allowed.get(name)) for name, own in each.items()]
        blocks.append(_quantile_table(quantiles, found.precision))
    failed = failures(found.failures())
    if len(failed):
        blocks.append(_failure_table(failed))
    text = (
        "Every attempt counts, whatever became of it. The gap is (length − reference) / "
        "max(reference, R) and only a path that arrives has one; the others count as "
        "infinitely far off."
    )
    return Section("success", "Success and gaps", text, tuple(blocks))


def _experiment_table(each: Mapping[str, Attempts]) -> Table:
    parts = [summary(own.verdicts()).assign(experiment=name) for name, own in each.items()]
    frame = pd.concat(parts, ignore_index=True)
    left_out = ("optimal", "none exists", "not_returned")  # the rest says it, and fits
    kept = [column for column in _summary_columns() if column.key not in left_out]
    columns = (Column("experiment", "experiment", kind="code"), *kept)
    caption = "The same counts experiment by experiment: each was put to other solvers."
    return Table("summary-by-experiment", caption, frame, columns, _bad_counts(frame))


def _verdict_picture(found: Attempts) -> Picture:
    frame = summary(found.verdicts())
    lines = max(name_of(solver).count("\n") + 1 for solver in frame["solver"])
    figure = new_figure(WIDE, 0.9 + max(0.42, 0.14 * lines) * len(frame))
    plot_verdicts(figure.add_subplot(), frame)
    caption = (
        "Verdicts as shares of all attempts. Plain bars are successes, hatched ones are not; false "
        "claims and wrong basins are counted at the right."
    )
    return Picture("verdicts", caption, figure, "Stacked bars of verdicts, one a solver")


def _tolerances(results: Results) -> dict[str, float]:
    """The gap that each experiment's runs call optimal; left out where two runs differ."""
    found: dict[str, set[float | None]] = {}
    for run in results.folders:
        found.setdefault(run.name, set()).add(run.manifest.gap_tolerance)
    return {name: gap for name, (gap, *others) in found.items() if gap is not None and not others}


def _profile_picture(experiment: str, found: Attempts, tolerance: float | None) -> Picture:
    shares = gap_shares(found.gap_profile())
    figure = new_figure(HALF, 3.0 + 0.17 * legend_lines(list(shares), width=40))
    ax = figure.add_subplot()
    plot_gap_profile(ax, shares, tolerance)
    figure.legend(loc="outside lower left", ncols=1, fontsize=7.5)
    caption = (
        f"Experiment {experiment}: share of attempts within each gap. Higher is more reliable, "
        "further left more accurate; a curve that ends below 100 % belongs to a solver that "
        "sometimes does not arrive."
    )
    alt = f"Share of attempts against gap, {experiment}"
    return Picture(f"gap-profile-{slug(experiment)}", caption, figure, alt, True)


def _quantile_table(frame: pd.DataFrame, precision: str) -> Table:
    gap = digits(3)
    columns = (
        Column("solver", "solver", kind="code"),
        Column("region", "target lies", kind="text"),
        Column("attempts", "attempts", count),
        Column("arrived", "arrive", share),
        Column("q50", "median gap", gap),
        Column("q90", "90 %", gap),
        Column("q99", "99 %", gap),
        Column("q100", "worst", gap),
    )
    caption = (
        "Gap quantiles (relative, no unit) by where the target lies. ∞ means that so large a share "
        "of the attempts did not arrive that the quantile is not reached."
        f"{precision}"
    )
    return Table("gap-quantiles", caption, frame, columns)


def _failure_table(failed: pd.DataFrame) -> Table:
    frame = failed.head(_MOST_FAILURES).reset_index(drop=True)
    columns = (
        Column("solver", "solver", kind="code"),
        Column("outcome", "outcome", kind="text"),
        Column("claim", "claim", kind="text"),
        Column("verdict", "verdict", kind="text"),
        Column("said", "the backend said", kind="prose"),
        Column("attempts", "attempts", count),
    )
    caption = (
        "Attempts without success by what was said of them (# stands for a number), the "
        f"{_MOST_FAILURES} most frequent."
    )
    return Table("failures", caption, frame, columns)
