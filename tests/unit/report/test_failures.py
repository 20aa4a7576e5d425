"""Failures, and answers where no path exists.

They are counted by hand; some outcomes are no failures.
"""

import math
import shlex

import pandas as pd
import pytest

from dubins_study import load_results
from dubins_study.report.data.results import load
from dubins_study.report.page.render import render
from dubins_study.report.statistics.methods import compared
from dubins_study.report.statistics.metrics import success
from dubins_study.report.topics.existence import existence, existence_section
from dubins_study.report.topics.failures import failures, failures_section
from dubins_study.report.topics.summary import solver_summary
from dubins_study.report.two_runs.changes import pairs
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim, Verdict
from tests.unit.report.results_folder import astray, attempt, lost, paper_scenarios
from tests.unit.report.topic_page import topic_page

NEAR, FAR = Scenario(0, 0, 0, 2, 2.5), Scenario(0, 0, 0, 30, 1)
TURNED = Scenario(5, 5, math.pi / 2, 5, 7.6, 2.0)  # straight ahead, 1.3 radii away
IN_DISC = Scenario(0, 0, 0, 0.2, 1.0)
SAID = {"message": "stopped after 1.11 s; the limit is 1 s"}


def silent(scenario, solver, outcome, **changes):
    """An attempt without an answer."""
    changes = {"outcome": outcome, "message": ""} | changes
    return attempt(scenario, solver, path=None, claim=Claim.NONE, **changes)


def rows():
    """Rows with failures and right answers.

    They are two timeouts, a crash, a miss, two that say they failed, and seven right answers.
    """
    misses = {"path": astray(IN_DISC, 0.1), "message": "off by 7.5"}
    failed = [
        attempt(where, "b", path=None, claim=Claim.FAILED, message=f"off by {k}.5e-0{k}", repeat=k)
        for k, where in enumerate((TURNED, FAR), 1)
    ]
    return [
        silent(NEAR, "a", "timeout", **SAID),
        silent(FAR, "a", "timeout", message="stopped after 1.20 s; the limit is 1 s"),
        silent(IN_DISC, "a", "out_of_memory"),
        attempt(TURNED, "a"),
        attempt(NEAR, "b"),
        attempt(IN_DISC, "b", claim=Claim.FAILED, **misses),
        *failed,
        *(attempt(where, "c") for where in (NEAR, FAR, TURNED, IN_DISC)),
    ]


@pytest.fixture
def folder(results):
    """The rows' folder, with 1.5 s an attempt."""
    return results("e", rows(), time_limit_s=1.5)


def test_messages_that_differ_in_numbers_are_one(folder):
    """Messages that differ in numbers are one.

    Stopped ones come first; the example is the first repeat, then the nearest target.
    """
    table = failures(load([folder]).attempts)
    lines = table.set_index(["solver", "outcome", "verdict"])

    assert table["attempts"].sum() == 6
    assert table["attempts"].tolist() == [2, 1, 2, 1]
    stopped = lines.loc[("a", "timeout", "none")]
    assert (stopped["message"], stopped["attempts"]) == ("stopped after # s; the limit is # s", 2)
    assert (stopped["target_x"], stopped["target_y"]) == (2, 2.5)
    line = lines.loc[("b", "returned", "none")]
    assert (line["message"], line["attempts"], line["repeat"]) == ("off by #", 2, 1)


def test_the_section_counts_and_its_commands_repeat_a_failure(folder, tmp_path):
    section = failures_section(load([folder]))
    table = next(block for block in section.blocks if block.name == "failures")
    line = table.frame.set_index("outcome").loc["timeout"]

    assert "3 of 12 attempts did not return (2 timeout, 1 out of memory)." in section.text
    assert "Of 12 attempts at questions that have a path, 6 failed (50.0 %)" in section.text
    command = "dubins-study solve --time-limit 1.5 --solver a -- 2 2.5"
    assert shlex.split(line["command"]) == shlex.split(command)
    page = topic_page(folder, tmp_path / "out", "failures").read_text(encoding="utf-8")
    assert "--time-limit 1.5 --solver a -- 2 2.5" in page
    assert page.count('<section id="failures"') == 1


def test_without_failures_a_sentence(load_rows):
    """Without failures there is a sentence.

    There is no table where nothing failed, nothing was asked, or none exists and that was found.
    """
    good = failures_section(load_rows("good", [attempt(NEAR), attempt(FAR)]))
    none = failures_section(load_rows("none", [attempt(IN_DISC, branch="LS")]))

    for section in (good, none, failures_section(None)):
        assert not section.blocks
        assert not section.text
    assert good.lead == none.lead == "Nothing failed."
    assert "No attempt was recorded" in failures_section(None).lead


def rows_with(undecided: int) -> list[dict[str, object]]:
    """Right and undecided attempts of a solver.

    Three are right.
    """
    scenarios = paper_scenarios()
    rows = [attempt(scenario, "ipopt", claim=Claim.LOCAL) for scenario in scenarios[:3]]
    for scenario in scenarios[3 : 3 + undecided]:
        route = {"via_x": [9.0], "via_y": [9.0], "region": None, "margin": None, "gap": 0.1}
        open_ = {
            "verdict": str(Verdict.UNDECIDED),
            "claim": "optimal",
            "scenario_id": f"{id(route)}",
        }
        rows.append(attempt(scenario, "ipopt", **route | open_))
    return rows


@pytest.mark.parametrize("undecided", [0, 2])
def test_no_share_counts_them(load_rows, undecided):
    results = load_rows("run", rows_with(undecided))
    line = solver_summary(results.attempts).iloc[0]

    assert (line["attempts"], line["questions"], line["right"]) == (3, 3, 3)
    assert line["undecided"] == undecided
    assert line["longer"] == line["false_claims"] == 0
    assert line["right_share"] == 1
    assert failures(results.attempts).empty
    assert existence(results.attempts).empty
    assert success(results.rows).sum() == 3


def test_an_open_question_is_left_out_for_every_solver(load_rows):
    """An open question is left out for everyone.

    A good answer there is undecided and no trial; a bad one must be none either.
    """
    rows = rows_with(1)
    rows.append(rows[-1] | {"solver": "slsqp", "verdict": "longer"})
    attempts = load_rows("run", rows).attempts

    assert attempts["answerable"].tolist() == [True] * 3 + [False] * 2
    assert attempts["left_open"].tolist() == [False] * 3 + [True] * 2
    assert existence(attempts).empty


def test_a_comparison_leaves_them_out(load_rows):
    """A comparison leaves open questions out.

    A question that was right and is undecided now is not lost.
    """
    base, new = load_rows("base", rows_with(0)), load_rows("new", rows_with(2)[1:])

    assert len(pairs(base, new)) == 2


def not_taken(scenario, solver="ipopt"):
    """The row of a solver that was not called."""
    return lost(scenario, solver, outcome="unsupported", label="route", via_x=[9.0], via_y=[9.0])


def test_a_question_that_a_solver_does_not_take_is_no_failure(load_rows, results):
    """A question that is not taken is no failure.

    All numbers are those of the run in which it was not asked, and a sentence tells them.
    """
    scenarios = paper_scenarios()
    asked = [attempt(s, "ipopt", claim=Claim.LOCAL) for s in scenarios[:3]]
    asked.append(lost(scenarios[3], "ipopt", outcome="timeout"))
    more = [*asked, *map(not_taken, scenarios[4:])]
    fewer, every = load_rows("fewer", asked), load_rows("every", more)

    for found in (fewer, every):
        line = solver_summary(found.attempts).iloc[0]
        assert (line["attempts"], line["questions"], line["right"]) == (4, 4, 3)
        assert (line["not_returned"], line["right_share"]) == (1, 0.75)
        assert failures(found.attempts)["attempts"].sum() == 1
        assert success(found.rows).mean() == compared(found).rows["right"].mean() == 0.75
        assert existence(found.attempts).empty
    assert "3 more questions" not in failures_section(fewer).text
    assert "3 more questions" in failures_section(every).text
    assert len(load_results(results("read", more))) == 7


def test_a_run_of_which_no_question_was_taken_makes_a_page(results):
    page = render([results("run", [not_taken(s) for s in paper_scenarios()])])

    assert "7 more questions" in page.read_text(encoding="utf-8")


# The left disc has its centre at (0, 1): an LS path cannot end inside.
INSIDE = [Scenario(0, 0, 0, x, 1.0) for x in (-0.4, -0.2, 0.2, 0.4)]
OUTSIDE = [Scenario(0, 0, 0, x, 1.0) for x in (3.0, 4.0, 5.0)]


def ask(scenario, claim, path=None, **changes):
    """An engine's answer to LS.

    The scenario's place names it.
    """
    changes = {"scenario_id": f"{scenario.target_x:g}"} | changes
    return attempt(scenario, "b", "LS", path=path, claim=claim, **changes)


def answers():
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
        (answers(), {"presolved": 1, "reached": 3, "wall_s": 2.0}),
        (answers(), {"right_share": 1 / 3, "silent_share": 1 / 3, "wrong_share": 1 / 3}),
        # a path that is denied is a wrong answer of its own; a failure denies nothing
        (answers(), {"questions": 3, "denied": 1, "denied_share": 1 / 3}),
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
    """The section marks errors and names deniers.

    A denial is told in the text with its share; both kinds of error are marked.
    """
    section = existence_section(load_rows("e", answers()))
    (table,) = section.blocks
    wrong = [key for (_, key), mark in table.marks.items() if mark == "bad"]

    assert sorted(wrong) == ["denied_text", "wrong_text"]
    assert "say of a question with a path that there is none" in section.text
    assert table.frame["denied_text"].tolist() == ["33.3 % of 3,\n6.1 to 79.2 %"]  # Wilson's
    assert "33.3 % of 3" in section.text


def test_a_presolve_that_answers_all_leaves_the_engine_out(load_rows):
    """A presolve that answers everything hides the engine.

    Then shares of the engine's answers are not defined, and its time is missing.

    Without a question that has no path there is no section.
    """
    attempts = [ask(INSIDE[0], Claim.INFEASIBLE, presolved=True)]
    results = load_rows("e", attempts)
    line = line_of(results)
    (table,) = existence_section(results).blocks
    asked = [ask(OUTSIDE[2], Claim.LOCAL, "exact")]

    assert existence_section(load_rows("asked", asked)) is None
    assert math.isnan(line["right_share"])
    assert pd.isna(line["wall_s"])
    shown = dict(zip([column.key for column in table.columns], table.texts()[0], strict=True))
    assert {shown[key] for key in ("right_text", "wall_s")} == {"–"}
