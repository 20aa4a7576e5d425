"""Hostile plug-ins beside an honest one.

Each has one right row, and nothing is left behind.
"""

import re
from pathlib import Path

import psutil
import pytest

from dubins_study.study.rows.schema import KEY, names
from tests.faults.conftest import ASKED, TABLES
from tests.faults.experiments import lasting
from tests.live_run import study

RUNS = [
    pytest.param((kind, jobs), marks=[pytest.mark.slow] * slow, id=f"{kind}, {jobs} jobs")
    for kind, jobs, slow in (
        *(("quick", 2, False), ("quick", 1, True), ("endless", 2, True)),
        *(("greedy", 2, True), ("stuck", 2, True)),
    )
]
EACH = [
    pytest.param(*run.values, name, marks=run.marks, id=f"{run.id}, {name}")
    for run in RUNS
    for name in TABLES[run.values[0][0]][0]
]
in_every_run = pytest.mark.parametrize("shared", RUNS, indirect=True)
in_a_quick_run = pytest.mark.parametrize("shared", RUNS[:2], indirect=True)


def check(found, case):
    """Check the rows of one plug-in."""
    shown = found[["outcome", "verdict", "native_status", "message"]].to_dict("records")
    for row in found.to_dict("records"):
        assert re.fullmatch(case.outcome, row["outcome"]), shown
        assert re.fullmatch(case.verdict, row["verdict"]), shown
        assert row["false_claim"] == case.false_claim, shown
        assert re.search(case.native, row["native_status"]), shown
        assert re.search(case.message, row["message"], re.DOTALL), shown
        if row["outcome"] != "returned":
            assert row["claim"] == "none", shown
            assert row["curvatures"] is None
            assert row["reference"] > 0  # the question's own columns stay


def of(run, name):
    return run.rows[run.rows["plugin"] == name.split(":")[1]]


@pytest.mark.parametrize(("shared", "name"), EACH, indirect=["shared"])
def test_each_has_its_rows(shared, name):
    case_rows = of(shared, name)

    assert len(case_rows) == shared.asked
    check(case_rows, shared.table[name])
    late = case_rows[case_rows["outcome"] == "timeout"]
    # generous: how late exactly is for the benchmarks
    assert late["wall_s"].between(shared.limit, shared.limit + 5).all()


@in_every_run
def test_no_row_is_lost_or_doubled(shared):
    assert shared.ended.code == 0, shared.ended.err
    assert len(shared.rows) == shared.asked * len(shared.table) + ASKED
    assert not shared.rows.duplicated(names(KEY)).any()
    assert shared.rows["run_id"].nunique() == 1


@in_every_run
def test_the_honest_solver_beside_them_answers_as_if_alone(shared, clean):
    beside = lasting(of(shared, "honest:Honest"))

    assert set(beside["verdict"]) == {"optimal"}
    assert beside.equals(lasting(clean))


@in_every_run
def test_no_process_outlives_the_run(shared):
    """No process outlives the run.

    It is looked for by its mark, and by the numbers that the plug-ins wrote down of themselves.
    """
    noted = shared.scratch / "pids"
    pids = [int(line) for line in noted.read_text().split()] if noted.exists() else []

    assert shared.ended.alive == []
    assert [pid for pid in pids if psutil.pid_exists(pid) and status(pid) != "zombie"] == []
    # a slow machine may end a plug-in before its second process has noted itself
    noting = sum("pids" in case.files for case in shared.table.values())
    assert len(pids) >= noting  # else this test would see nothing


def status(pid):
    try:
        return psutil.Process(pid).status()
    except psutil.Error:
        return "zombie"


@in_every_run
def test_what_solvers_print_stays_theirs(shared):
    """Solvers' output stays out of the run's output.

    stdout holds the run's own summary; no log on stderr grows with what solvers print.
    """
    out, err = shared.ended.out, shared.ended.err

    for theirs in ("flood", "variables", "licence licence", "Assertion", "<script>", "\x1b[31mred"):
        assert theirs not in out
    # of a solver's name, the place of its file counts for nothing
    assert len(out.replace(str(Path(__file__).parent), "")) < 10_000
    assert len(err) < 200_000
    assert "Traceback" not in err


@in_a_quick_run
def test_words_are_short_and_can_be_shown(shared):
    """Messages are short and can be shown.

    Last words and errors fit a row, and hold nothing that a terminal obeys.
    """
    crashed = shared.rows[shared.rows["outcome"] == "crashed"]
    others = shared.rows[shared.rows["outcome"] != "crashed"]

    assert (crashed["message"].str.len() <= 400).all()
    assert (others["message"].str.len() <= 10_000).all()
    for message in (*crashed["message"], *others["message"]):
        message.encode()
    shown = study("status", shared.folder)
    assert shown.code == 0, shown.err
    assert "\x1b" not in shown.out


@in_a_quick_run
def test_nothing_of_a_flood_is_kept_on_disk(shared):
    left = [file for file in shared.scratch.rglob("*") if file.is_file()]

    assert sum(file.stat().st_size for file in left) < 10 * 2**20, left
