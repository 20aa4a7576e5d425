"""What several answers together say of a mistake that one alone does not."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from dubins_study.conformance import questions
from dubins_study.conformance.answers import Kind, Problem
from dubins_study.conformance.causes import SWAPPED_SIDES, cause_of
from dubins_study.conformance.interview import Seen
from dubins_study.study.words import Verdict


def of_another_question(earlier_seen: Iterable[Seen], seen: Seen, problem: Problem) -> Problem:
    """A problem; where its path was right for an earlier question, with advice about that."""
    path = seen.answer.path
    if problem.kind is not Kind.CONTROLS or path is None or not path.length.size:
        return problem
    if cause_of(seen.question.scenario, path):
        return problem
    for earlier in earlier_seen:
        other = earlier.answer.path
        if (
            earlier.answer.verdict in (Verdict.OPTIMAL, Verdict.LONGER)
            and other is not None
            and np.array_equal(other.curvature, path.curvature)
            and np.array_equal(other.length, path.length)
        ):
            name = questions.name_of(earlier.question.scenario) or "another one"
            advice = (
                f"this is its answer to an earlier question, {name}: does it keep answers, by the "
                "target alone for instance? Start, heading and radius belong to the question"
            )
            return problem._replace(finding=replace(problem.finding, advice=advice))
    return problem


def of_one_side(answers: list[Seen], shown: list[Problem]) -> list[Problem]:
    """The problems; where left and right are swapped at turns to one side only, this is said."""
    sides: dict[bool, set[str]] = {True: set(), False: set()}  # whether the path arrives
    for seen in answers:
        answer = seen.answer
        if answer.reference_word and answer.path is not None:
            arrives = answer.verdict in (Verdict.OPTIMAL, Verdict.LONGER)
            sides[arrives].add(answer.reference_word[0])
    for side, other, name, sign in (
        ("R", "L", "right", "negative"),
        ("L", "R", "left", "positive"),
    ):
        if sides[False] == {side} and other in sides[True]:
            advice = f"only turns to the {name} go wrong: their curvature is {sign}"
            shown = [
                one._replace(finding=replace(one.finding, advice=advice))
                if one.finding.advice == SWAPPED_SIDES
                else one
                for one in shown
            ]
    return shown
