"""The committed rows of the benchmark hold.

They are whole, and the check still says the same of their controls.

The rows may be of earlier code of a solver: an hour's run is not repeated for every edit. So that
they stay true nevertheless, the check judges the stored controls anew, and a sample of the cells
is solved anew.
"""

from dataclasses import replace
from pathlib import Path as FilePath
from typing import NamedTuple

import numpy as np
import pytest

from dubins_study.experiments.definition.experiment import read
from dubins_study.experiments.plan.cells import chains
from dubins_study.experiments.solve import solve
from dubins_study.experiments.store.folder import read_rows
from dubins_study.solvers.registry import load, unavailable
from dubins_study.study.judging.certify import certify
from dubins_study.study.judging.judge import judge
from dubins_study.study.path import Path
from dubins_study.study.rows.manifest import read_manifest
from dubins_study.study.rows.schema import ANSWER, CELL, KEY, RUN, SCENARIO, names
from dubins_study.study.scenario_frame import scenario_of
from dubins_study.study.tolerances import ARRIVES
from dubins_study.study.words import FORMULATIONS, Claim, Order

RESULTS = FilePath(__file__).parents[2] / "results" / "benchmark"


class Suite(NamedTuple):
    """A suite and the sizes that tests judge.

    It has its easiest stratum, and the legs up to which a slow test judges its rows.
    """

    easiest: str
    most_legs: int


SUITES = {
    "leg": Suite("outside, near", 1),
    "pose": Suite("far: 4 R to 20 R", 1),
    "route": Suite("legs of 4 R to 20 R", 20),
    "tour": Suite("8 R sqrt(n)", 7),
}
PROVED_WIDTH = 1e-7  # relative; an interval that is wider is open
# Engines whose makers do not wish that others publish their times.
LICENSED = {"Gurobi", "Xpress", "KNITRO", "COPT", "BARON"}
FEW_LEGS = 5  # of the quick tests: beyond, a reference takes seconds


@pytest.fixture(scope="module", params=SUITES)
def suite(request):
    return request.param


@pytest.fixture(scope="module")
def table(suite):
    columns = [*names(KEY), *names(SCENARIO), *names(ANSWER), *names(RUN), "margin"]
    return read_rows(RESULTS / suite, list(dict.fromkeys(columns))).to_pandas()


def rows_of(table):
    return table.to_dict("records")


def relative_width(table):
    """Relative widths of the proven intervals.

    They are relative to the length; NaN without a path.
    """
    return (table["reference_high"] - table["reference_low"]) / table["reference_low"]


@pytest.mark.slow
def test_it_is_the_experiment_of_today(suite, table):
    """It is the experiment of today.

    Its text and its cells are those that `make benchmark` would ask for now.
    """
    packaged = read(f"benchmark-{suite}")
    asked = {cell.key[:-1] for chain in chains(packaged.experiment) for cell in chain}

    assert read_manifest(RESULTS / suite).experiment.text == packaged.text
    assert asked == set(table[names(CELL)].itertuples(index=False, name=None))


def test_every_row_names_its_formulation_engine_and_guess(table):
    assert set(table["formulation"]) <= set(FORMULATIONS)
    assert table[["engine", "guess"]].notna().all(axis=None)
    assert not set(table["engine"]) & LICENSED


@pytest.mark.many(1)
@pytest.mark.parametrize("share", [0.03, pytest.param(1, marks=pytest.mark.slow)])
def test_its_verdicts_are_what_the_check_says_today(suite, table, share):
    """Its verdicts are the check's of today.

    A share of the first repeats is judged and certified again from the stored controls. Open
    questions are left out: how far a search narrows them depends on the machine's speed.
    """
    first = table[(table["repeat"] == 0) & ~(relative_width(table) > PROVED_WIDTH)]
    most_legs = FEW_LEGS if share < 1 else SUITES[suite].most_legs
    first = first[first["via_x"].map(lambda via: via is None or len(via) < most_legs)]
    rows = first.sample(frac=share, random_state=1)
    # costates take most of the time, and of a scenario many solvers find the same path: they are
    # measured once for each formulation, verdict and level of proof
    alike = ["scenario_id", "branch", "formulation", "verdict", "proof"]
    for row, measured in zip(rows_of(rows), ~rows.duplicated(alike), strict=True):
        scenario = scenario_of(row)
        path = None
        if row["curvatures"] is not None:
            path = Path(scenario.start, row["curvatures"], row["lengths"])
        bound = None if np.isnan(row["lower_bound"]) else row["lower_bound"]
        judgement = judge(scenario, path, Claim(row["claim"]), row["branch"])
        driven = path if measured else None
        certificate = certify(scenario, driven, judgement, row["branch"], lower_bound=bound)

        assert judgement.verdict == row["verdict"]
        assert judgement.false_claim == row["false_claim"]
        assert certificate.false_bound == row["false_bound"]
        if measured and not row["presolved"]:
            assert certificate.proof == row["proof"]
        if not np.isnan(row["gap"]):
            # other libraries' sines and sums: a few ulp; of a route a search may end elsewhere in
            # the proven intervals, then's and today's
            moved = 0.0
            if row["via_x"] is not None:
                moved = row["reference_high"] - row["reference_low"]
                moved += certificate.reference_high - certificate.reference_low
            atol = 1e-13 + moved / max(row["reference_low"], row["radius"])
            np.testing.assert_allclose(judgement.gap, row["gap"], rtol=1e-6, atol=atol)


@pytest.mark.parametrize("most_legs", [1, pytest.param(FEW_LEGS, marks=pytest.mark.slow)])
def test_no_question_lies_next_to_a_jump(table, most_legs):
    """No question lies next to a jump.

    The shortest length moves little where points do, by 100 times the tolerance of arriving.

    Next to a jump a miss within the tolerance may be worth a full turn. With a free final heading
    one leg jumps at the turning circles alone: its margin tells.
    """
    random = np.random.default_rng(46)
    judged = table[table["reference_low"].notna()].drop_duplicates("scenario_id")
    for row in rows_of(judged):
        scenario = scenario_of(row)
        legs = len(scenario.via) + 1
        far = 100 * ARRIVES * scenario.radius
        if scenario.one_free_leg:
            assert abs(row["margin"]) > 0.999 * far / scenario.radius, scenario
        elif (
            legs <= most_legs and scenario.order is not Order.FREE
        ):  # a tour's order may change there
            angle = random.uniform(0.0, 2 * np.pi, legs)
            step = far * np.stack([np.cos(angle), np.sin(angle)], axis=1)
            points = np.array([*scenario.via, (scenario.target_x, scenario.target_y)])
            *via, (x, y) = (points + step).tolist()
            moved = solve(replace(scenario, via=via, target_x=x, target_y=y), limit=60.0)

            # where two arcs become one a leg goes with the root of the distance; a jump is a turn
            steep = legs * np.sqrt(100 * ARRIVES) * scenario.radius
            assert abs(moved.length - row["reference_low"]) < 2 * steep, scenario


@pytest.mark.slow
def test_easy_cells_solved_anew_end_alike(suite, table):
    """Easy cells solved anew are right again.

    Each engine is asked a cell that it had right, where it is easiest. Left out are solvers that
    are killed at their limit, and COBYQA, which takes half a minute: on a busy machine the limit
    ends them.
    """
    easy = table[(table["label"] == SUITES[suite].easiest) & (table["repeat"] == 0)]
    # not at a limit, which a solver that took so long goes to, however far it is
    ended = easy["claim"].isin(["local", "optimal", "feasible"]) & (easy["wall_s"] < 0.5)
    easy = easy[ended & (easy["verdict"] == "optimal") & easy["curvatures"].notna()]
    for row in rows_of(easy.drop_duplicates("engine")):
        spec = row["solver"]
        solver = load(row["solver"])
        slow = "cobyqa" in spec or not solver.keeps_limit
        if slow or unavailable(solver) is not None:
            continue
        answer = solve(scenario_of(row), spec, row["branch"], limit=30.0)

        assert answer.verdict == "optimal", (spec, row["scenario_id"], answer.message)
