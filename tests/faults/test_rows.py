"""Hostile plug-ins beside an honest one: one right row each, and nothing left behind."""

from __future__ import annotations

import re

import psutil
import pytest

from tests.faults import expected
from tests.faults.conftest import ASKED
from tests.faults.launch import lasting, study

SHARED = [
    ("quick", expected.CRASHES | expected.RAISES | expected.ANSWERS, 2),
    ("endless", expected.ENDLESS, 1),
    ("greedy", expected.MEMORY, 1),
]
FIXTURES = [name for name, _, _ in SHARED]


def check(found, name, case):
    """The rows of one plug-in against what is expected of them."""
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


@pytest.mark.parametrize("name", expected.CRASHES | expected.RAISES | expected.ANSWERS)
def test_quick_ones(quick, name):
    table = expected.CRASHES | expected.RAISES | expected.ANSWERS
    found = of(quick, name)
    assert len(found) == 2
    check(found, name, table[name])


@pytest.mark.parametrize("name", expected.ENDLESS)
def test_endless_ones(endless, name):
    found = of(endless, name)
    assert len(found) == 1
    check(found, name, expected.ENDLESS[name])
    late = found[found["outcome"] == "timeout"]
    assert late["wall_s"].between(0.5, 5.0).all()  # generous: how late is for the benchmarks


@pytest.mark.parametrize("name", expected.MEMORY)
def test_greedy_ones(greedy, name):
    found = of(greedy, name)
    assert len(found) == 1
    check(found, name, expected.MEMORY[name])


@pytest.mark.parametrize(("fixture", "table", "asked"), SHARED, ids=FIXTURES)
def test_no_row_is_lost_or_doubled(request, fixture, table, asked):
    run = request.getfixturevalue(fixture)

    assert run.ended.code == 0, run.ended.err
    keys = ["solver", "profile", "branch", "start", "repeat", "scenario_id"]
    assert len(run.rows) == asked * len(table) + ASKED
    assert not run.rows.duplicated(keys).any()
    assert run.rows["run_id"].nunique() == 1


@pytest.mark.parametrize("fixture", FIXTURES)
def test_the_honest_solver_beside_them_answers_as_if_alone(request, clean, fixture):
    run = request.getfixturevalue(fixture)
    beside = lasting(of(run, "honest:Honest"))

    assert set(beside["verdict"]) == {"optimal"}
    assert beside.equals(lasting(clean))


@pytest.mark.parametrize("fixture", FIXTURES)
def test_no_process_outlives_the_run(request, fixture):
    """By its mark, and by the numbers that the plug-ins wrote down of themselves."""
    run = request.getfixturevalue(fixture)
    noted = run.scratch / "pids"
    pids = [int(line) for line in noted.read_text().split()] if noted.exists() else []

    assert run.ended.alive == []
    assert not [pid for pid in pids if psutil.pid_exists(pid) and status(pid) != "zombie"]
    assert fixture != "endless" or len(pids) >= 7  # else this test would see nothing


def status(pid):
    try:
        return psutil.Process(pid).status()
    except psutil.Error:
        return "zombie"


@pytest.mark.parametrize("fixture", FIXTURES)
def test_what_solvers_print_stays_theirs(request, fixture):
    """stdout holds the run's own summary; no log on stderr grows with what solvers print."""
    run = request.getfixturevalue(fixture)
    out, err = run.ended.out, run.ended.err

    for theirs in ("flood", "licence", "Assertion", "<script>", "\x1b[31mred"):
        assert theirs not in out
    assert len(out) < 10_000
    assert len(err) < 200_000
    assert "Traceback" not in err


def test_a_trap_is_never_sprung(quick):
    """No text of a plug-in runs code in whoever reads its answer."""
    assert not (quick.scratch / "sprung").exists()


def test_words_are_short_and_can_be_shown(quick):
    """Last words and errors fit a row, and hold nothing that a terminal obeys."""
    crashed = quick.rows[quick.rows["outcome"] == "crashed"]
    others = quick.rows[quick.rows["outcome"] != "crashed"]

    assert (crashed["message"].str.len() <= 400).all()
    assert (others["message"].str.len() <= 10_000).all()
    for message in (*crashed["message"], *others["message"]):
        message.encode()
    shown = study("status", quick.folder)
    assert shown.code == 0, shown.err
    assert "\x1b" not in shown.out


def test_nothing_of_a_flood_is_kept_on_disk(quick):
    left = [file for file in quick.scratch.rglob("*") if file.is_file()]

    assert sum(file.stat().st_size for file in left) < 10 * 2**20, left
