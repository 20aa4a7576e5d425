"""Rows of two machines and two time limits.

They are shown side by side, never ranked.
"""

import json

import pandas as pd
import pytest

from dubins_study.report.data.results import load
from dubins_study.report.page.render import render
from dubins_study.report.statistics.methods import best_methods, compared
from dubins_study.report.topics.comparison import evaluations, times
from dubins_study.report.topics.decision import best_supported
from dubins_study.report.topics.failures import failures_section
from dubins_study.report.topics.findings_evidence import Evidence
from dubins_study.report.topics.single_attempts import sample
from dubins_study.report.topics.summary import solver_summary
from dubins_study.study.scenario import Scenario
from tests.unit.report.results_folder import attempt, lost, write_folder

QUESTIONS = [Scenario(target_x=4 + 0.25 * n, target_y=3, label="ahead") for n in range(32)]
OURS, THEIRS = "Linux x86_64, Z80, 4 cores", "Linux x86_64, Cray-1, 1 cores"
SLOW_S, QUICK_S, RIVAL_S = 0.5, 1e-3, 0.7
RUN = {"run_id": "abc", "state": "finished", "machine": {"system": "Linux"}}


def folder_of(place, name, solver, machine, wall_s, **manifest):
    """Right answers of one solver on one machine.

    It answers all questions.
    """
    known = {"machine": machine, "wall_s": wall_s, "solve_s": wall_s, "evaluations": 9}
    rows = [attempt(question, solver, **known, guesses="one") for question in QUESTIONS]
    return write_folder(place / solver, name, rows, runs=[RUN], **manifest)


@pytest.fixture
def folders(tmp_path):
    """Three solvers on two machines.

    They are ours, a slower rival on our machine, and one that was 500 times as quick on another.
    """
    return [
        folder_of(tmp_path, "benchmark", "slsqp", OURS, SLOW_S),
        folder_of(tmp_path, "benchmark", "ipopt", OURS, RIVAL_S),
        folder_of(tmp_path, "benchmark", "shooting", THEIRS, QUICK_S),
    ]


def test_times_of_another_machine_rank_nothing(folders):
    """Times of another machine rank nothing.

    The quick solver is neither the best of its kind, nor in a table of times, nor in a ratio.
    """
    results = load(folders)
    attempts = compared(results)
    summary = solver_summary(results.attempts)
    medians = summary.set_index("solver")["wall_s"]
    evidence = Evidence(attempts)

    assert medians[["slsqp", "ipopt"]].tolist() == [SLOW_S, RIVAL_S]
    assert pd.isna(medians["shooting"])
    assert best_supported(attempts.rows)["solver"].tolist() == ["slsqp"]
    assert best_methods(summary, ["formulation"])["solver"].tolist() == ["slsqp"]
    assert set(times(attempts).columns) == {"slsqp", "ipopt"}
    assert set(evaluations(attempts).columns) == {"slsqp", "ipopt", "shooting"}
    assert evidence.time_ratio("ipopt", "slsqp").value == pytest.approx(RIVAL_S / SLOW_S)
    assert evidence.time_ratio("shooting", "slsqp") is None
    assert summary.set_index("solver")["right"].eq(len(QUESTIONS)).all()


def test_times_of_another_machine_are_shown(folders):
    """Each attempt shows another machine's time."""
    shown = sample(load(folders), most=1000).groupby("solver")["wall_s"].median()

    assert shown.to_dict() == {"slsqp": SLOW_S, "ipopt": RIVAL_S, "shooting": QUICK_S}


def test_the_first_folder_says_which_machine_is_ours(folders):
    """The first folder's machine is ours.

    Rows of one machine are ranked, wherever they were made.
    """
    turned = load(folders[::-1])
    alone = load(folders[2:])

    assert set(turned.elsewhere["solver"]) == {"slsqp", "ipopt"}
    assert turned.rows.groupby("solver")["wall_s"].median()["shooting"] == QUICK_S
    assert len(alone.elsewhere) == 0


def test_failures_of_another_machine_are_no_times(tmp_path, folders):
    """Failures of another machine are no times.

    They count as failures in shares; in a table of times they would cost our limit.
    """
    gone = [lost(question, "disjunctive", machine=THEIRS, guesses="one") for question in QUESTIONS]
    attempts = compared(load([*folders, write_folder(tmp_path / "gone", "benchmark", gone)]))

    assert set(times(attempts).columns) == {"slsqp", "ipopt"}
    assert attempts.rows.query("solver == 'disjunctive'")["right"].eq(False).all()


def test_a_late_answer_of_another_machine_is_late(tmp_path, folders):
    """A late answer of another machine is late.

    Its own clock and its own limit decide, and its time is still not ours.
    """
    late = folder_of(tmp_path, "benchmark", "trust-constr", THEIRS, 3.0, time_limit_s=2.0)
    rows = load([*folders, late]).rows.query("solver == 'trust-constr'")

    assert rows["late"].all()
    assert rows["wall_s"].isna().all()


def suites(place, limit_s, sections=(None, None)):
    """A suite and a sample of it.

    The suite has a limit of 1 s, the sample another one: two questions of each.
    """
    of_suite, of_sample = sections
    suite = [attempt(question, "slsqp", limit_s=1.0) for question in QUESTIONS[:2]]
    again = [attempt(QUESTIONS[0], "ipopt", limit_s=limit_s), lost(QUESTIONS[5], "ipopt")]
    return [
        write_folder(place / "suite", "suite", suite, section=of_suite, time_limit_s=10.0),
        write_folder(place / "again", "again", again, section=of_sample, time_limit_s=10.0),
    ]


def test_a_question_with_two_limits_is_named(tmp_path, caplog):
    """A question with two limits is named.

    The page and the terminal name it, by the folder that differs from an earlier one.
    """
    folders = suites(tmp_path, limit_s=10.0)
    page = render(folders, tmp_path / "page")
    message = "1 of its questions have another time limit in a folder before it"

    assert [folder.rows.other_limits for folder in load(folders).folders] == [0, 1]
    assert f"{folders[1]}: {message}" in caplog.text
    assert message in page.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("limit_s", "sections"), [(1.0, (None, None)), (10.0, ("benchmark", "searches"))]
)
def test_questions_with_one_limit_are_not(tmp_path, caplog, limit_s, sections):
    """Neither are those of suites that have sections of their own."""
    folders = suites(tmp_path, limit_s, sections)

    assert [folder.rows.other_limits for folder in load(folders).folders] == [0, 0]
    assert "time limit" not in caplog.text


def test_commands_repeat_an_attempt_with_its_own_limit(tmp_path):
    """Commands repeat an attempt with its own limit.

    The general limit of its suite serves only rows without a limit.
    """
    rows = [lost(QUESTIONS[0], "slsqp", limit_s=1.0), lost(QUESTIONS[1], "ipopt", limit_s=None)]
    results = load([write_folder(tmp_path / "suite", "suite", rows, time_limit_s=10.0)])
    table = next(block for block in failures_section(results).blocks if block.name == "failures")
    commands = dict(zip(table.frame["solver"], table.frame["command"], strict=True))
    limits = sample(results, most=10).set_index("solver")["limit_s"]

    assert " --time-limit 1 " in commands["slsqp"]
    assert " --time-limit 10 " in commands["ipopt"]
    assert json.loads(limits.to_json()) == {"slsqp": 1.0, "ipopt": 10.0}
