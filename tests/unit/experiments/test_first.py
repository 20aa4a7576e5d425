"""Solvers that are asked only the first scenarios of every sample."""

from __future__ import annotations

from collections import Counter

import pytest

from dubins_study.experiments.definition.experiment import ExperimentError, parse
from dubins_study.experiments.plan.cells import chains

RANGES = "{ target_x = { linear = [2, 9] }, target_y = { linear = [2, 9] } }"
TEXT = """
title = "t"
question = "?"
solvers = ["analytic"]
first = { scenarios = 2, solvers = ["slsqp"] }
[[scenarios]]
label = "sampled"
sample = { method = "sobol", count = 8, seed = 3, ranges = RANGES }
[[scenarios]]
label = "with solvers of its own"
solvers = ["ipopt"]
sample = { method = "sobol", count = 4, seed = 3, ranges = RANGES }
[[scenarios]]
target_x = 3
target_y = 3
""".replace("RANGES", RANGES)


def cells_of(text):
    return [cell for chain in chains(parse("t", "t.toml", text).experiment) for cell in chain]


def test_they_share_the_first_scenarios_with_the_others():
    cells = cells_of(TEXT)
    ids = {
        solver: [c.scenario_id for c in cells if c.solver == solver]
        for solver in ("analytic", "slsqp")
    }

    assert Counter(cell.solver for cell in cells) == {"analytic": 9, "ipopt": 4, "slsqp": 2}
    assert ids["slsqp"] == ids["analytic"][:2]


@pytest.mark.parametrize(
    "first", ["{ scenarios = 0, solvers = ['slsqp'] }", "{ scenarios = 2, solvers = [] }", "2"]
)
def test_a_wrong_table_is_refused_by_name(first):
    with pytest.raises(ExperimentError, match="first"):
        cells_of(TEXT.replace('{ scenarios = 2, solvers = ["slsqp"] }', first))


def test_without_a_sample_it_is_refused():
    """It would ask nobody."""
    text = 'title = "t"\nquestion = "?"\nsolvers = ["slsqp"]\n'
    text += 'first = { scenarios = 1, solvers = ["ipopt"] }\n'

    with pytest.raises(ExperimentError, match="first: expected a block with a sample"):
        cells_of(text + "[[scenarios]]\ntarget_x = [3, 5]\ntarget_y = 1\n")
