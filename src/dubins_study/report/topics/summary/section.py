"""The first section: every solver's attempts in one table."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.attempts import PRESOLVED, SUCCESSES, VERDICTS
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, columns, marks
from dubins_study.report.elements.content import Section, Table
from dubins_study.report.elements.formats import count, seconds, share, some
from dubins_study.report.topics.summary.numbers import summary

VERDICT_COLUMNS = (
    SOLVER,
    *columns(count, **{key: key for key in ("attempts", *VERDICTS)}),
    *columns(share, success="success"),
    *columns(count, false_claims="false claims", wrong_basins="wrong basins"),
    *columns(count, not_returned="not returned"),
    *columns(seconds, wall_s="median time"),
)

_PRESOLVED_TEXT = (
    "By presolve: the solver's setting presolve answered that no path exists, which is no success "
    "of its engine. "
)


def failure_marks(frame: pd.DataFrame) -> dict[tuple[int, str], str]:
    """Marks for the counts above zero of answers that are wrong or missing."""
    return marks(frame, "misses", "none", "false_claims", "not_returned")


def summary_section(results: Results) -> Section | None:
    """Attempts, verdicts and times, solver by solver."""
    attempts = results.attempts
    frame = summary(attempts.verdicts())
    presolved = bool(frame[PRESOLVED].any())
    caption = (
        "What the check finds of every attempt. Success is optimal or none exists, as a share of "
        f"all attempts, those that failed included. {_PRESOLVED_TEXT if presolved else ''}"
        "A false claim says more than the check finds; a wrong basin is a longer path that turns "
        "by another angle. Not returned: timed out, crashed, raised, unsupported or unavailable."
        f"{attempts.precision}"
    )
    # the column makes the table too wide for the page where it is not needed
    shown = [column for column in VERDICT_COLUMNS if presolved or column.key != PRESOLVED]
    experiments = list(
        dict.fromkeys(run.name for run in results.folders if run.name in attempts.experiments)
    )
    right = frame[list(SUCCESSES)].to_numpy().sum() / attempts.count
    text = (
        f"{some(attempts.count, 'attempt')} by {some(len(frame), 'solver')} in the "
        f"{'experiment' if len(experiments) == 1 else 'experiments'} {', '.join(experiments)}; "
        f"success: {share(right)}. No number here rests on a solver's own word: each path "
        "is driven again from its controls and judged against the closed form."
    )
    table = Table("summary", caption, frame, tuple(shown), failure_marks(frame))
    return Section("summary", "Summary", text, (table,))
