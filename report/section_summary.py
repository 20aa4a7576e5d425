"""The first section: every solver's attempts in one table and one chart."""

from __future__ import annotations

from report.content import Column, Picture, Section, Table, count, seconds, share
from report.figures_success import plot_gap_profile, plot_verdicts
from report.load import Results
from report.metrics import answerable, failures, gap_quantiles, success, summary
from report.content import digits
from report.style import WIDE, new_figure

_MOST_FAILURES = 25


def summary_section(results: Results) -> Section | None:
    """Attempts, verdicts and times, solver by solver."""
    rows = results.rows
    frame = summary(rows)
    columns = (
        Column("solver", "solver", kind="code"),
        Column("attempts", "attempts", count),
        Column("optimal", "optimal", count),
        Column("none exists", "none exists", count),
        Column("longer", "longer", count),
        Column("misses", "misses", count),
        Column("none", "none", count),
        Column("success", "success", share),
        Column("false_claims", "false claims", count),
        Column("wrong_basins", "wrong basins", count),
        Column("not_returned", "not returned", count),
        Column("wall_s", "median time", seconds),
    )
    marks = {
        (i, key): "bad"
        for i, row in enumerate(frame.to_dict("records"))
        for key in ("misses", "none", "false_claims", "not_returned")
        if row[key]
    }
    caption = (
        "What the check found of every attempt. Success is optimal or none exists, as a share of "
        "all attempts, those that failed included. A false claim says more than the check finds; "
        "a wrong basin is a longer path that turns another way, honestly called local. "
        "Not returned: timed out, crashed, raised, unsupported or unavailable."
    )
    asked = ", ".join(dict.fromkeys(m.name for m in results.manifests))
    right = float(success(rows).mean())
    text = (
        f"{count(len(rows))} attempts by {len(frame)} solvers in the experiments {asked}; "
        f"{share(right)} of them succeed. No number here rests on a solver's own word: each path is driven "
        "again from its controls and judged against the closed form."
    )
    return Section("summary", "Summary", text, (Table("summary", caption, frame, columns, marks),))


def success_section(results: Results) -> Section | None:
    """Verdicts, gap profile, gap quantiles per region, and what failed."""
    rows = results.rows
    blocks: list[Picture | Table] = [_verdict_picture(results)]
    asked = answerable(rows)
    if len(asked):
        blocks += [_profile_picture(results), _quantile_table(results)]
    failed = failures(rows)
    if len(failed):
        blocks.append(_failure_table(results))
    text = (
        "Every attempt counts, whatever became of it. The gap is (length − reference) / "
        "max(reference, R) and only a path that arrives has one; the others count as infinitely far off."
    )
    return Section("success", "Success and gaps", text, tuple(blocks))


def _verdict_picture(results: Results) -> Picture:
    frame = summary(results.rows)
    figure = new_figure(WIDE, 0.9 + 0.42 * len(frame))
    plot_verdicts(figure.add_subplot(), frame)
    caption = (
        "Verdicts as shares of all attempts. Plain bars are successes, hatched ones are not; false "
        "claims and wrong basins are counted at the right."
    )
    return Picture("verdicts", caption, figure, "Stacked bars of verdicts, one a solver")


def _profile_picture(results: Results) -> Picture:
    figure = new_figure(WIDE, 3.2)
    plot_gap_profile(figure.add_subplot(), results.rows)
    caption = (
        "Share of attempts within each gap: higher is more reliable, further left is more "
        "accurate. A curve that ends below 100 % belongs to a solver that sometimes does not arrive."
    )
    return Picture("gap-profile", caption, figure, "Cumulative share of attempts against gap")


def _quantile_table(results: Results) -> Table:
    frame = gap_quantiles(results.rows)
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
    )
    return Table("gap-quantiles", caption, frame, columns)


def _failure_table(results: Results) -> Table:
    frame = failures(results.rows).head(_MOST_FAILURES).reset_index(drop=True)
    columns = (
        Column("solver", "solver", kind="code"),
        Column("outcome", "outcome", kind="text"),
        Column("claim", "claim", kind="text"),
        Column("verdict", "verdict", kind="text"),
        Column("said", "the backend said", kind="text"),
        Column("attempts", "attempts", count),
    )
    caption = (
        f"Attempts without success by what was said of them, the {_MOST_FAILURES} most frequent."
    )
    return Table("failures", caption, frame, columns)
