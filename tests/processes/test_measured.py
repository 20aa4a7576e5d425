"""Measures of a run beside the answers.

They are the floor of an engine's times, and memory.
"""

import pytest

from dubins_study import load_results, run

EXPERIMENT = """
title = "measured"
question = "what does it cost?"
time_limit_s = 20
solvers = ["analytic", "slsqp", "ipopt", "shooting", "disjunctive", "turn-rate-qp",
    "penalty[engine=powell]", "heavy.py:Heavy"]

[[scenarios]]
x = 0
y = 0
heading = 0.3
target_x = [4, 5]
target_y = 3
radius = 1
"""
HEAVY = '''
from dataclasses import dataclass
import numpy as np
from dubins_study import Claim, Solution, Solver

@dataclass(frozen=True)
class Heavy(Solver):
    """Fills 64 MiB, and lets them go."""
    name = "heavy"
    def solve(self, question, limit):
        np.ones(8 * 2**20).sum()
        return Solution(Claim.FAILED, None)
'''


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    folder = tmp_path_factory.mktemp("measured")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        (folder / "heavy.py").write_text(HEAVY)
        (folder / "measured.toml").write_text(EXPERIMENT)
        return load_results(run("measured.toml", trust_plugins=True))


@pytest.mark.slow
def test_every_engine_has_a_floor(rows):
    """Every engine has a floor.

    A formula and a plug-in of no engine of ours have none.
    """
    without = rows["solver"].isin(["analytic", "heavy.py:Heavy"])
    assert rows.loc[without, "floor_s"].isna().all()
    assert (rows.loc[~without, "floor_s"] > 0).all()


def test_memory_is_what_the_solve_added(rows):
    """Memory is that which the solve added.

    64 MiB of doubles are counted, whatever was held before; a formula adds nothing like it.
    """
    heavy = rows.loc[rows["solver"] == "heavy.py:Heavy", "memory_mib"]
    assert heavy.between(60, 80).all(), heavy
    assert rows.loc[rows["solver"] == "analytic", "memory_mib"].between(0, 16).all()
