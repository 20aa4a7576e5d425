"""What a new run does worse than its base: one line per question or solver, with its scenario."""

from __future__ import annotations

from collections.abc import Callable

import pandas as pd

from dubins_study.report.data.command import solve_command
from dubins_study.report.elements.formats import digits, seconds, share
from dubins_study.report.two_runs.numbers import less_accurate, lost, newly_false

# A time regression is as sure as the tests of the page.
ALPHA = 0.05

COLUMNS = ("kind", "solver", "scenario", "branch", "base", "new", "command")


def regressions(
    pairs: pd.DataFrame, changes: pd.DataFrame, unanswered: pd.DataFrame, slower: float
) -> pd.DataFrame:
    """What became worse, in the order of the kinds.

    Args:
        pairs: as `pairs.pairs` returns it.
        changes: of `numbers.solver_changes`.
        unanswered: of the new run, as `pairs.unanswered` returns it.
        slower: a solver is slower if the interval of its time ratio lies above this, and the test
            finds a difference.
    Returns:
        Columns kind (`no longer right`, `no longer denied`, `false claim`, `less accurate`,
        `right less often`, `slower`, `not answered`), solver, scenario (its label, or its target),
        branch, base and new (as text), and the command that asks the question again. The last three
        kinds are of all questions of a solver: without scenario.
    """
    tables = [_questions(pairs, kind) for kind in _KINDS]
    tables += [_less_often(changes), _slower(changes, slower), _not_answered(unanswered)]
    frame = pd.concat(tables, ignore_index=True)
    return frame[list(COLUMNS)]


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
_KINDS: dict[str, tuple[Callable[[pd.DataFrame], pd.Series[bool]], str, _Text]] = {
    "no longer right": (lambda pairs: lost(pairs) & pairs["answerable"], "right", _right),
    "no longer denied": (lambda pairs: lost(pairs) & ~pairs["answerable"], "right", _right),
    "false claim": (newly_false, "false", lambda value: "a false claim" if value else "none"),
    "less accurate": (less_accurate, "gap", _gap),
}


def _questions(pairs: pd.DataFrame, kind: str) -> pd.DataFrame:
    chosen, column, show = _KINDS[kind]
    rows = pairs[chosen(pairs)]
    return pd.DataFrame(
        {
            "kind": kind,
            "solver": rows["solver"],
            "scenario": [_scenario(row) for _, row in rows.iterrows()],
            "branch": rows["branch"],
            "base": [show(value) for value in rows[f"{column}_base"]],
            "new": [show(value) for value in rows[f"{column}_new"]],
            "command": [solve_command(row) for _, row in rows.iterrows()],
        },
        columns=list(COLUMNS),
    )


def _scenario(row: pd.Series) -> str:
    place = f"target {row['target_x']:.6g}, {row['target_y']:.6g}"
    return f"{row['label']}: {place}" if row["label"] else place


def _less_often(changes: pd.DataFrame) -> pd.DataFrame:
    rows = changes[right_less_often(changes)] if len(changes) else changes
    return pd.DataFrame(
        [
            {
                "kind": "right less often",
                "solver": row["solver"],
                "scenario": f"all {row['questions']} questions with a path",
                "branch": "",
                "base": f"right in {share(row['right_base'])}",
                "new": f"right in {share(row['right_new'])}",
                "command": "",
            }
            for _, row in rows.iterrows()
        ],
        columns=list(COLUMNS),
    )


def _slower(changes: pd.DataFrame, slower: float) -> pd.DataFrame:
    rows = changes[slower_solvers(changes, slower)] if len(changes) else changes
    ratio = digits(3)
    return pd.DataFrame(
        [
            {
                "kind": "slower",
                "solver": row["solver"],
                "scenario": f"mean of {row['timed']} questions",
                "branch": "",
                "base": seconds(row["time_base"]),
                "new": f"{ratio(row['time_ratio'])} times as long "
                f"({ratio(row['time_ratio_low'])} to {ratio(row['time_ratio_high'])})",
                "command": "",
            }
            for _, row in rows.iterrows()
        ],
        columns=list(COLUMNS),
    )


def _not_answered(unanswered: pd.DataFrame) -> pd.DataFrame:
    lines = [
        (
            "not answered",
            line.solver,
            "",
            "",
            "",
            f"{line.rows} of the {line.cells} cells asked",
            "",
        )
        for line in unanswered.itertuples()
    ]
    return pd.DataFrame(lines, columns=list(COLUMNS))
