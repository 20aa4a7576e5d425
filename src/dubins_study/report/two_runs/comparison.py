"""What a comparison of two runs says: what became worse, and a verdict for each solver."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path as FilePath

import pandas as pd

from dubins_study.report.data.command import solve_command
from dubins_study.report.elements.formats import digits, seconds, share
from dubins_study.report.two_runs.changes import ENDS, SIDES, less_accurate, lost, newly_false
from dubins_study.report.two_runs.circumstances import MachineSpeed


@dataclass(frozen=True, eq=False)
class Comparison:
    """What two runs have in common, and what changed.

    Args:
        solvers: one row per solver; columns of `report.two_runs.changes.solver_changes`.
        regressions: what became worse, with the scenario and the command that repeats it; columns
            of `regressions` below.
        unpaired: solver, and how many questions only one of the runs was asked.
        differences: what, base, new: what else the runs differ in.
        speed: of the new run's machine by the base's; None if nothing says it.
        slower: how many times as long counts as slower.
        page: the page that was written; None if none was asked for.
    """

    solvers: pd.DataFrame
    regressions: pd.DataFrame
    unpaired: pd.DataFrame
    differences: pd.DataFrame
    speed: MachineSpeed | None
    slower: float
    page: FilePath | None = None

    @property
    def regressed(self) -> bool:
        """Whether anything became worse."""
        return not self.regressions.empty


# A time regression is as sure as the tests of the page.
ALPHA = 0.05

_SAYS = ("scenario", "branch", "base", "new", "command")


def regressions(
    pairs: pd.DataFrame, changes: pd.DataFrame, unanswered: pd.DataFrame, slower: float
) -> pd.DataFrame:
    """What became worse, in the order of the kinds; of the new run the cells without an answer.

    Columns kind (`no longer right`, `no longer denied`, `false claim`, `less accurate`, `right less
    often`, `slower`, `not answered`), solver, scenario (its label, or its target), branch, base and
    new (as text), and the command that asks the question again. The last three kinds are of all
    questions of a solver: without scenario.
    """
    worse = {kind: pairs[chosen(pairs)] for kind, (chosen, _, _) in _OF_QUESTIONS.items()}
    if len(changes):
        worse["right less often"] = changes[right_less_often(changes)]
        worse["slower"] = changes[slower_solvers(changes, slower)]
    worse["not answered"] = unanswered
    lines = [
        (kind, row["solver"], *_line(kind, row))
        for kind, rows in worse.items()
        for _, row in rows.iterrows()
    ]
    return pd.DataFrame(lines, columns=["kind", "solver", *_SAYS])


def slower_solvers(changes: pd.DataFrame, slower: float) -> pd.Series[bool]:
    """Whether each solver's time ratio lies above the bound, interval and all, and the test agrees.

    Where the machine's speed is not known, `time_p` is NaN and no solver is called slower.
    """
    return changes["time_ratio_low"].gt(slower) & changes["time_p"].lt(ALPHA)


def right_less_often(changes: pd.DataFrame) -> pd.Series[bool]:
    """Whether a solver's share of right answers fell, by its interval and by the paired test.

    That is seen in repeats too: a question that is right in one of three was right in all.
    """
    return changes["right_change_high"].lt(0) & changes["right_p"].lt(ALPHA)


def _gap(value: float) -> str:
    return f"gap {digits(2)(value)}" if value == value else "no path that arrives"


def _right(value: float) -> str:
    return f"right in {share(value)} of the repeats"


_Text = Callable[[float], str]
# kind -> the questions, the column and how its values are shown
_OF_QUESTIONS: dict[str, tuple[Callable[[pd.DataFrame], pd.Series[bool]], str, _Text]] = {
    "no longer right": (lambda pairs: lost(pairs) & pairs["answerable"], "right", _right),
    "no longer denied": (lambda pairs: lost(pairs) & ~pairs["answerable"], "right", _right),
    "false claim": (newly_false, "false", lambda value: "a false claim" if value else "none"),
    "less accurate": (less_accurate, "gap", _gap),
}


def _line(kind: str, row: pd.Series) -> tuple[str, ...]:
    """The columns `_SAYS` of a regression."""
    if kind in _OF_QUESTIONS:
        _, column, show = _OF_QUESTIONS[kind]
        place = f"target {row['target_x']:.6g}, {row['target_y']:.6g}"
        scenario = f"{row['label']}: {place}" if row["label"] else place
        values = (show(row[f"{column}_{side}"]) for side in SIDES)
        return scenario, row["branch"], *values, solve_command(row)
    if kind == "right less often":
        shares = (f"right in {share(row[f'right_{side}'])}" for side in SIDES)
        return f"all {row['questions']} questions with a path", "", *shares, ""
    if kind == "slower":
        ratio, low, high = (digits(3)(row[f"time_ratio{end}"]) for end in ENDS)
        took = f"{ratio} times as long ({low} to {high})"
        return f"mean of {row['timed']} questions", "", seconds(row["time_base"]), took, ""
    return "", "", "", f"{row['rows']} of the {row['cells']} cells asked", ""


NO_CHANGE, SAME_CODE = "no change", "same code"


def with_verdicts(comparison: Comparison) -> pd.DataFrame:
    """`comparison.solvers` with a column verdict: what is worse, else what is better."""
    worse = comparison.regressions.groupby("solver")["kind"].agg(
        lambda kinds: list(dict.fromkeys(kinds))
    )
    frame = comparison.solvers
    verdicts = [
        "worse: " + ", ".join(worse[row["solver"]])
        if row["solver"] in worse.index
        else _better(row, comparison.slower)
        for _, row in frame.iterrows()
    ]
    return frame.assign(verdict=verdicts)


def _better(row: pd.Series, slower: float) -> str:
    """A solver is faster, and right more often, by the mirror images of what makes it worse."""
    better = {
        f"{row['gained']} more right": row["gained"] > 0,
        "right more often": row["right_change_low"] > 0 and row["right_p"] < ALPHA,
        "faster": row["time_ratio_high"] < 1 / slower and row["time_p"] < ALPHA,
    }
    texts = [text for text, applies in better.items() if applies]
    if texts:
        return "better: " + ", ".join(texts)
    return SAME_CODE if row["same_code"] else NO_CHANGE
