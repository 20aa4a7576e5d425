"""Rising experiments stop where a solver fails.

A solver that fails on all routes of a size is not asked the longer ones.
"""

import pytest

from dubins_study import load_results, run

# `late` answers one leg by a straight line that misses, so it fails on the smallest size.
RISING = """
title = "rising"
question = "who still finds the shortest route?"
rising = true
time_limit_s = 20
solvers = ["analytic", "headings[engine=powell]", "late.py:Late"]

[[scenarios]]
label = "{label}"
[scenarios.route]
legs = [3, 1]
spacing = "4R-20R"
count = 2
seed = 1

[[scenarios]]
label = "{label}"
time_limit_s = 30
[scenarios.route]
legs = [5]
spacing = "4R-20R"
count = 2
seed = 1
"""
LATE = '''
from dataclasses import dataclass
from dubins_study import Claim, Path, Solution, Solver

@dataclass(frozen=True)
class Late(Solver):
    """Finds no route of one leg; counts in a file how often it is asked."""
    name = "late"
    takes = frozenset({"free final heading", "final heading", "via points"})
    def solve(self, question, limit):
        if question.scenario.label != "warm-up":
            with open("asked.txt", "a") as file:
                print(question.scenario.legs, limit, file=file)
        return Solution(Claim.FAILED, None)
'''


def rows_by_size(folder):
    frame = load_results(folder)
    frame["legs"] = [1 if via is None else len(via) + 1 for via in frame["via_x"]]
    return frame


def test_a_solver_that_fails_on_a_size_is_not_asked_larger_ones(tmp_path, monkeypatch):
    """A failing solver is not asked larger sizes.

    Its rows say so and count as failures; others go on; a second run asks nobody again.
    """
    monkeypatch.chdir(tmp_path)
    (tmp_path / "late.py").write_text(LATE)
    (tmp_path / "rising.toml").write_text(RISING.format(label="a"))

    folder = run("rising.toml", trust_plugins=True)
    again = rows_by_size(run("rising.toml", trust_plugins=True))

    frame = rows_by_size(folder)
    assert again.equals(frame)
    late = frame[frame["solver"].str.startswith("late")]
    assert dict(zip(late["legs"], late["outcome"], strict=True)) == {
        1: "returned",
        3: "not_asked",
        5: "not_asked",
    }
    assert set(late["verdict"]) == {"none"}
    others = frame.drop(late.index)
    assert set(others["outcome"]) == {"returned"}
    assert set(others["verdict"]) == {"optimal"}
    asked = {line.split()[0] for line in (tmp_path / "asked.txt").read_text().splitlines()}
    assert asked == {"1"}


@pytest.mark.slow
def test_a_block_has_a_time_limit_of_its_own(tmp_path, monkeypatch):
    """A block has a time limit of its own.

    Each row says its limit; a limit that is asked for replaces all of them.
    """
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rising.toml").write_text(RISING.format(label="b"))

    frame = rows_by_size(run("rising.toml", solvers=["analytic"]))
    forced = rows_by_size(run("rising.toml", "forced", solvers=["analytic"], time_limit=25))

    assert frame.groupby("legs")["limit_s"].unique().map(list).to_dict() == {
        1: [20.0],
        3: [20.0],
        5: [30.0],
    }
    assert set(forced["limit_s"]) == {25.0}


DIES = '''
import os
from dataclasses import dataclass
from dubins_study import Claim, Solution, Solver

warm = False

@dataclass(frozen=True)
class Dies(Solver):
    """Ends its process at the warm-up of a route; tells whether it was warmed up on a leg."""
    name = "dies"
    takes = frozenset({"free final heading", "via points"})
    def solve(self, question, limit):
        global warm
        if question.scenario.label == "warm-up":
            if question.scenario.via:
                os._exit(3)
            warm = True
        return Solution(Claim.FAILED, None, message=f"warm: {warm}")
'''


def test_a_warm_up_that_fails_on_a_route_leaves_that_on_a_leg(tmp_path, monkeypatch):
    """A failed warm-up on routes keeps that on legs.

    Else each later worker would pay for its imports within the limit of a question.
    """
    monkeypatch.chdir(tmp_path)
    (tmp_path / "dies.py").write_text(DIES)
    text = RISING.format(label="c").replace("late.py:Late", "dies.py:Dies")
    (tmp_path / "routes.toml").write_text(text.replace("rising = true", ""))

    frame = rows_by_size(run("routes.toml", solvers=["dies.py:Dies"], trust_plugins=True))

    assert set(frame["legs"]) == {1, 3, 5}
    assert set(frame["outcome"]) == {"returned"}
    assert set(frame["message"]) == {"warm: True"}


TOURS = """
title = "rising"
question = "who still finds the shortest tour?"
rising = true
time_limit_s = 20
solvers = ["tourist.py:Late"]

[[scenarios]]
[scenarios.tour]
points = [3, 2, 4]
density = "8R"
count = 1
seed = 1
end = "any"
"""


def test_tours_rise_by_their_points(tmp_path, monkeypatch):
    """Tours rise by their points.

    One that may end at any point has as many legs; the smallest is asked, and fails.
    """
    monkeypatch.chdir(tmp_path)
    takes = '"via points"})'
    assert takes in LATE
    (tmp_path / "tourist.py").write_text(LATE.replace(takes, '"via points", "free order"})'))
    (tmp_path / "tours.toml").write_text(TOURS)

    frame = load_results(run("tours.toml", trust_plugins=True))

    sizes = frame["via_x"].map(len)
    assert dict(zip(sizes, frame["outcome"], strict=True)) == {
        2: "returned",
        3: "not_asked",
        4: "not_asked",
    }
    assert frame["target_x"].isna().all()
