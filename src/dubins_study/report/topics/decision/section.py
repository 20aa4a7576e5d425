"""The first section: which method to use, by the target's place, accuracy and need of proof."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import Column, columns
from dubins_study.report.elements.content import Place, Section, Table
from dubins_study.report.elements.formats import count, seconds, sentences, share, some
from dubins_study.report.elements.identity import with_interval
from dubins_study.report.elements.names import labels_of
from dubins_study.report.elements.topic import General, Topic
from dubins_study.report.statistics.compared import Compared, compared
from dubins_study.report.topics.decision.cases import cases_table
from dubins_study.report.topics.decision.numbers import (
    ANYWHERE,
    NEEDS,
    REGIONS,
    SURE,
    Choice,
    choices,
    closed_form,
    false_provers,
)

TITLE = "What to use"
_USABLE = 0.5  # a method that fails more often than not is none to use
_NUMBERS = ("solver", "share", "low", "high", "wall_s")


def decision_section(results: Results) -> Section | None:
    """A table of choices; without attempts to choose from, a sentence that says so."""
    attempts = compared(results)
    if attempts is None:
        return Section("decision", TITLE, _nothing(), (), "Nothing can be recommended here.")
    found, exact = choices(attempts), closed_form(attempts)
    text = sentences("" if exact else _unasked(), _alone(found), _liars(attempts))
    if not found:
        return Section("decision", TITLE, text, (), f"{_baseline(exact)}; no engine was asked.")
    table = _table(found, labels_of(results))
    return Section(
        "decision",
        TITLE,
        text,
        (table, cases_table(results)),
        f"{_baseline(exact)}; {_advice(found)}",
    )


def _nothing() -> str:
    return (
        "These rows hold no attempt by which solvers can be compared: each began from another "
        "solver's path, or its engine was not installed or cannot read the question."
    )


def _baseline(exact: Choice | None) -> str:
    """The closed form is always there to be used; here it may not have been asked."""
    if exact is None:
        return "If you only need the path, use the closed form"
    if not exact.solver:
        return f"The closed form, the baseline, is right on none of {exact.questions} questions"
    return (
        f"If you only need the path, use the closed form (right on {_success(exact)} of "
        f"{some(exact.questions, 'question')}, {seconds(exact.wall_s)} in the median)"
    )


def _advice(found: Sequence[Choice]) -> str:
    if not any(choice.solver for choice in found):
        return "no other method was right on any question, so that none can be recommended."
    return (
        "for problems like it that have no formula, find the line of your target and the column "
        "of your need."
    )


def _unasked() -> str:
    return (
        "The closed form was not asked here, so that its time is not known; the check compares "
        "every answer with it all the same."
    )


def _alone(found: Sequence[Choice]) -> str:
    if found and max(choice.methods for choice in found) == 1:
        return "Only one method was asked: the table shows how it does, and leaves no choice."
    return ""


def _liars(attempts: Compared) -> str:
    liars = false_provers(attempts)
    if not liars:
        return ""
    return (
        f"{some(len(liars), 'method')} with a false proof at any question "
        f"{'is' if len(liars) == 1 else 'are'} left out where a proof is needed."
    )


def _table(found: Sequence[Choice], labels: dict[str, str]) -> Table:
    by_region: dict[str, dict[str, Choice]] = {}
    for choice in found:
        by_region.setdefault(choice.region, {})[choice.need.key] = choice
    lines = [_line(region, row, labels) for region, row in by_region.items()]
    marks = {
        (place, key): "note"
        for place, row in enumerate(by_region.values())
        for key, choice in row.items()
        if not choice.share >= SURE
    }
    shown = (
        *columns(kind="text", where="target"),
        *(Column(need.key, need.title, kind="pick") for need in NEEDS),
    )
    numbers = ("region", "questions", *(f"{n.key}_{name}" for n in NEEDS for name in _NUMBERS))
    sure = f"{100 * SURE:g} %"
    caption = (
        "Each cell names one method: engine, formulation, and the settings that are not the usual "
        "ones (the section on solvers and their settings has its spec for the command line). Below "
        "the name: the share of the questions at which it meets the need, with the 95 % interval "
        "(Wilson, a trial a question), and the median time of an attempt, failures included. The "
        f"method is the fastest of those that meet the need on at least {sure} of the questions; "
        "of several that are within a tenth of the least time it is the surest. In grey: no method "
        f"reaches {sure}, and the one is named that is most surely right (the largest lower end of "
        "its interval). In brackets after a target: the number of questions. They ask for the "
        "shortest path of all; those for one word count only if there are no others. The circles "
        "are the two of radius R along which the vehicle can turn at the start. Where a name says "
        "nothing of an initial guess, the search starts along the bearing of the target. Each "
        "method was chosen by these same rows, which flatters it a little."
    )
    return Table("decision", caption, pd.DataFrame(lines), shown, marks, numbers, stacked=True)


def _line(region: str, row: dict[str, Choice], labels: dict[str, str]) -> dict[str, object]:
    questions = next(iter(row.values())).questions
    place = ANYWHERE if region == ANYWHERE else REGIONS[region]
    line: dict[str, object] = {"where": f"{place} ({count(questions)})", "region": region}
    line["questions"] = questions
    for key, choice in row.items():
        line[key] = _cell(choice, labels)
        line |= {f"{key}_{name}": getattr(choice, name) for name in _NUMBERS}
    return line


def _cell(choice: Choice, labels: dict[str, str]) -> str:
    if not choice.solver:
        return "none" if choice.methods else "none asked"
    label = labels.get(choice.solver, choice.solver)
    numbers = f"{_success(choice)}, {seconds(choice.wall_s)}".replace(" ", "\u00a0")
    numbers = numbers.replace(",\u00a0", ", ").replace("\u00a0(", " (")
    if choice.share < _USABLE:
        return f"none\nat best {label}: {numbers}"
    return f"{label}\n{numbers}"


def _success(choice: Choice) -> str:
    return with_interval(share, choice.share, choice.low, choice.high)


TOPIC = Topic("what to use", decision_section, General.DECIDED, place=Place.FRONT)
