"""The section on questions without a path.

It shows which solvers recognise that no path exists.
"""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.attempts import (
    PRESOLVED,
    SUCCESSES,
    first_true,
    is_true,
    methods,
    questions,
)
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns, marks
from dubins_study.report.elements.content import General, Section, Table, Topic
from dubins_study.report.elements.formats import count, seconds, sentences, share, some
from dubins_study.report.elements.identity import method_columns, with_share
from dubins_study.report.elements.identity import questions as question_count
from dubins_study.report.statistics.methods import methods_of
from dubins_study.report.topics.summary import share_keys
from dubins_study.study.words import DENIALS, Claim

_ANSWERS = ("right", "local", "silent", "wrong")
KINDS = ("presolved", "unasked", *_ANSWERS)


def existence(attempts: pd.DataFrame) -> pd.DataFrame:
    """What each solver answers where no path exists.

    One row per solver that was asked a question without a path, or that denied a path. A number
    counts questions, and repeats are parts of one.

    Returns:
        The columns of `methods_of`, and these.

        Of questions without a path: presolved; unasked (the solver is not installed); reached (that
        reached the engine). Of those that reached the engine: right; local (a local engine found no
        path near its last point); wrong (a false claim); silent (no claim). wall_s is the median of
        the attempts that reached the engine, s.

        Of questions with a path: questions, denied (claimed infeasible, locally or not).

        Those of `with_share` for right, local, silent and wrong, as shares of `reached`, and for
        denied, as a share of `questions`.
    """
    there = attempts["answerable"]
    verdict = attempts["verdict"]
    false = attempts["false_claim"]
    local = attempts["claim"].eq(Claim.LOCALLY_INFEASIBLE)
    conditions = {
        "": there | attempts["left_open"],
        "presolved": verdict.eq(PRESOLVED),
        "unasked": attempts["outcome"].eq("unavailable"),
        "right": verdict.isin(SUCCESSES) & ~local,
        "local": verdict.isin(SUCCESSES),
        "wrong": is_true(false),
    }
    kind = first_true(conditions, "silent")
    denied = there & attempts["claim"].isin(DENIALS)
    chosen = {name: kind.eq(name) for name in KINDS} | {"questions": there, "denied": denied}
    counts = pd.DataFrame({name: questions(attempts, which) for name, which in chosen.items()})
    times = attempts["wall_s"].where(kind.isin(_ANSWERS))
    counts["wall_s"] = times.groupby(attempts["solver"]).median()
    frame = methods_of(methods(attempts)).join(counts).reset_index()
    frame["reached"] = frame[list(_ANSWERS)].sum(axis="columns").round(6)
    for name in _ANSWERS:
        frame = with_share(frame, name, frame[name], frame["reached"])
    frame = with_share(frame, "denied", frame["denied"], frame["questions"])
    was_asked = (frame[["reached", "presolved"]] > 0).any(axis="columns")
    return frame[was_asked | (frame["denied"] > 0)].reset_index(drop=True)


_LEAD = "See which solvers prove that no path exists, say nothing, or are wrong."
_COLUMNS = (
    *columns(question_count, presolved="by presolve"),
    *columns(kind="cell", right_text="right", local_text="locally"),
    *columns(kind="cell", silent_text="silent", wrong_text="wrong"),
    *columns(seconds, wall_s="median time"),
    *columns(kind="cell", denied_text="denies a path"),
)
_NUMBERS = (
    "solver",
    "unasked",
    "reached",
    *share_keys(*_ANSWERS),
    "questions",
    "denied",
    *share_keys("denied"),
)


def existence_section(results: Results) -> Section | None:
    """The section on questions without a path.

    It has right, silent and wrong answers where no path exists, and paths that are denied.
    """
    frame = existence(results.attempts)
    if not (frame[["reached", "presolved"]].any(axis=None)):
        return None
    points = last_points(results.attempts)
    text = sentences(_text(frame), _points_text(points))
    tables = [_table(frame)]
    if len(points):
        tables.append(_points_table(points))
    return Section("existence", "Where no path exists", text, tuple(tables), _LEAD)


# A point is stationary if a step of one radian or radius removes at most this share of the
# violation. It is the tolerance with which a path must arrive.
_STATIONARY = 1e-6


def last_points(attempts: pd.DataFrame) -> pd.DataFrame:
    """Ends without a path, by engine and claim.

    An end counts if the attempt did not satisfy the equations at its last point. It is stationary
    if no small change of the unknowns lowers the violation of the equations. Columns: engine,
    claim, ends, with_path (ends at a question that has a path), stationary, and those of
    `with_share` for stationary.
    """
    ended = attempts[attempts["violation_slope"].notna()]
    stationary = ended["violation_slope"] <= _STATIONARY
    ends = ended.assign(stationary=stationary, with_path=ended["answerable"])
    groups = ends.groupby(["engine", "claim"], observed=True)
    frame = groups[["with_path", "stationary"]].sum().assign(ends=groups.size()).reset_index()
    return with_share(frame, "stationary", frame["stationary"], frame["ends"])


def _points_text(points: pd.DataFrame) -> str:
    """A sentence on claims of local infeasibility.

    It has the share of these ends that are stationary; empty if there are no such ends.
    """
    local = points[points["claim"] == Claim.LOCALLY_INFEASIBLE]
    ends = int(local["ends"].sum())
    if not ends:
        return ""
    return (
        f"Local engines called {some(ends, 'last point')} locally infeasible. At "
        f"{share(local['stationary'].sum() / ends)} of them no small change reduces the miss."
    )


def _points_table(points: pd.DataFrame) -> Table:
    """The table of last points without a path."""
    caption = (
        "Last points of local engines that return no path. Stationary: by the equations' "
        f"derivatives a step of 1 removes at most {_STATIONARY:g} of the violation. `Locally "
        "infeasible` claims this; other engines stop at such points too, but cannot report it."
    )
    shown = (
        *columns(kind="text", engine="engine", claim="it says"),
        *columns(count, ends="last points", with_path="where a path exists"),
        *columns(kind="cell", stationary_text="stationary"),
    )
    numbers = ("stationary", *share_keys("stationary"))
    return Table("last-points", caption, points, shown, numbers=numbers, dense=True)


def _text(frame: pd.DataFrame) -> str:
    """Sentences on all solvers together.

    `frame` is that of `existence`.
    """
    reached = frame["reached"].sum()
    presolved = frame["presolved"].sum()
    total = reached + presolved
    names = {
        "right": "right",
        "local": "right of the last point alone",
        "silent": "silent",
        "wrong": "wrong",
    }
    shares = frame[list(names)].sum() / max(reached, 1)
    parts = [f"{text}: {share(shares[name])}" for name, text in names.items()]
    denied = frame[frame["denied"] > 0]
    by_presolve = ""
    if presolved:
        by_presolve = (
            f"The presolve alone answers {share(presolved / total)} of the questions without a "
            "path."
        )
    by_engines = ""
    if reached:
        by_engines = f"Of those that reached an engine, {', '.join(parts)}."
    denials = ""
    if len(denied):
        worst = denied.sort_values("denied_share", kind="stable").iloc[-1]
        denials = (
            f"{len(denied)} of {len(frame)} solvers say of a question with a path that there is "
            f"none, at least near their last point, most often {worst['name']}: "
            f"{share(worst['denied_share'])} of {some(int(worst['questions']), 'question')}."
        )
    return sentences(
        "To recognise that no path exists is another task than to find one. A search that finds "
        "no path where none exists has not failed.",
        by_presolve,
        by_engines,
        denials,
    )


def _table(frame: pd.DataFrame) -> Table:
    """The table of answers where no path exists."""
    caption = (
        "Questions without a path, solver by solver. By presolve: no engine was asked. Right: it "
        "claims that no path exists; locally: that no path is near its last point; silent: it "
        "failed, reached a limit or claims nothing; wrong: it claims a path. Denies a path: of the "
        "questions that have one. Shares with their 95 % interval (Wilson)."
    )
    bad = frame.assign(wrong_text=frame["wrong"] > 0, denied_text=frame["denied"] > 0)
    return Table(
        "existence",
        caption,
        frame,
        (*method_columns(frame), *_COLUMNS),
        marks(bad, "wrong_text", "denied_text"),
        _NUMBERS,
        dense=True,
    )


TOPIC = Topic("where no path exists", existence_section, General.POOLED)
