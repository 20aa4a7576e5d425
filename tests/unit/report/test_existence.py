"""Recognising that no path exists: right, wrong and silent answers, counted by hand."""

from __future__ import annotations

import math

import pandas as pd
import pytest

from dubins_study.report.topics.existence import existence, existence_section
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import astray, attempt

# The left disc has its centre at (0, 1): an LS path cannot end inside.
INSIDE = [Scenario(0, 0, 0, x, 1.0) for x in (-0.4, -0.2, 0.2, 0.4)]
OUTSIDE = [Scenario(0, 0, 0, x, 1.0) for x in (3.0, 4.0, 5.0)]


def ask(scenario, claim, path=None, **changes):
    """An engine's answer to LS; the scenario's place names it."""
    changes = {"scenario_id": f"{scenario.target_x:g}"} | changes
    return attempt(scenario, "b", "LS", path=path, claim=claim, **changes)


def rows():
    """Four questions without a path, three with one."""
    return [
        ask(INSIDE[0], Claim.INFEASIBLE, wall_s=1.0),
        ask(INSIDE[1], Claim.FAILED, astray(INSIDE[1], 0.5), wall_s=2.0),
        ask(INSIDE[2], Claim.LOCAL, astray(INSIDE[2], 0.5), wall_s=4.0),
        ask(INSIDE[3], Claim.INFEASIBLE, presolved=True, wall_s=1e-4),
        ask(OUTSIDE[0], Claim.INFEASIBLE),
        ask(OUTSIDE[1], Claim.FAILED),
        ask(OUTSIDE[2], Claim.LOCAL, "exact"),
    ]


def line_of(results):
    frame = existence(results.attempts)
    (line,) = frame.to_dict("records")
    return line


SPLIT = [ask(INSIDE[0], c, repeat=n) for n, c in enumerate((Claim.INFEASIBLE, Claim.FAILED))]
NOT_ASKED = [
    ask(INSIDE[n], Claim.NONE, outcome=outcome)
    for n, outcome in ((1, "unsupported"), (2, "unavailable"))
]


@pytest.mark.parametrize(
    ("made", "expected"),
    [
        # the presolve's time is not the engine's
        (rows(), {"presolved": 1, "reached": 3, "wall_s": 2.0, "presolve_s": 1e-4}),
        (rows(), {"right_share": 1 / 3, "silent_share": 1 / 3, "wrong_share": 1 / 3}),
        # a path that is denied is a wrong answer of its own; a failure denies nothing
        (rows(), {"questions": 3, "denied": 1, "denied_share": 1 / 3}),
        # repeats are parts of a question: one trial, half of it right
        (SPLIT, {"right_of": 1, "right_share": 1 / 2, "silent_share": 1 / 2}),
        # who cannot be asked is not silent, and what a solver does not take is no question for it
        ([ask(INSIDE[0], Claim.INFEASIBLE), *NOT_ASKED], {"reached": 1, "unasked": 1, "right": 1}),
    ],
)
def test_the_counts_by_hand(load_rows, made, expected):
    line = line_of(load_rows("e", made))

    assert {name: line[name] for name in expected} == pytest.approx(expected)


def test_the_section_marks_what_is_wrong_and_says_who_denies(load_rows):
    """A denial is told in the text with its share; both kinds of error are marked."""
    section = existence_section(load_rows("e", rows()))
    (table,) = section.blocks
    wrong = [key for (_, key), mark in table.marks.items() if mark == "bad"]

    assert sorted(wrong) == ["denied_text", "wrong_text"]
    assert "call a question infeasible that has a path" in section.text
    assert table.frame["denied_text"].tolist() == ["33.3 % of 3,\n6.1 to 79.2 %"]  # Wilson's
    assert "33.3 % of 3" in section.text


def test_a_presolve_that_answers_all_leaves_the_engine_out(load_rows):
    """Then shares of the engine's answers are not defined, and its time is missing.

    Without a question that has no path there is no section.
    """
    made = [ask(INSIDE[0], Claim.INFEASIBLE, presolved=True)]
    results = load_rows("e", made)
    line = line_of(results)
    (table,) = existence_section(results).blocks
    asked = [ask(OUTSIDE[2], Claim.LOCAL, "exact")]

    assert existence_section(load_rows("asked", asked)) is None
    assert math.isnan(line["right_share"])
    assert pd.isna(line["wall_s"])
    shown = dict(zip([column.key for column in table.columns], table.texts()[0], strict=True))
    assert {shown[key] for key in ("right_text", "wall_s")} == {"–"}
