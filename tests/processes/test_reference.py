"""The committed reference run: whole, and still what the check says of its controls."""

from __future__ import annotations

from pathlib import Path as FilePath

import numpy as np
import pytest

from dubins_study.experiments.definition.experiment import read
from dubins_study.experiments.plan.cells import chains
from dubins_study.experiments.store.folder import done, read_rows
from dubins_study.solvers.registry import available_solvers
from dubins_study.study.check.certificate import certify
from dubins_study.study.check.verdict import judge
from dubins_study.study.claim import Claim
from dubins_study.study.path import Path
from dubins_study.study.rows.manifest import read_manifest
from dubins_study.study.rows.schema import ANSWER, KEY, SCENARIO, names
from dubins_study.study.scenario import Scenario

FOLDER = FilePath(__file__).parents[2] / "results" / "reference"


@pytest.fixture(scope="module")
def rows():
    columns = [*names(KEY), *names(SCENARIO), *names(ANSWER)]
    return read_rows(FOLDER, list(dict.fromkeys(columns))).to_pylist()


def test_it_is_the_experiment_of_today():
    """Its text and its cells are those that `dubins-study run reference` would ask for now."""
    found = read("reference")

    assert read_manifest(FOLDER).experiment.text == found.text
    assert {cell.key for chain in chains(found.experiment) for cell in chain} == done(FOLDER)


def test_all_solvers_are_in_it(rows):
    assert {row["solver"] for row in rows} == set(available_solvers())
    assert {row["outcome"] for row in rows} == {"returned"}


def test_its_verdicts_are_what_the_check_says_today(rows):
    """Judged and certified again from the stored controls: nothing has drifted."""
    for row in rows:
        scenario = Scenario(**{name: row[name] for name in names(SCENARIO)})
        path = (
            None
            if row["curvatures"] is None
            else Path(scenario.start, row["curvatures"], row["lengths"])
        )
        found = judge(scenario, path, Claim(row["claim"]), row["branch"])
        proof = certify(scenario, path, found, row["branch"], lower_bound=row["lower_bound"])

        assert found.verdict == row["verdict"]
        assert found.false_claim == row["false_claim"]
        assert proof.proof == row["proof"]
        if row["gap"] is not None:
            # other libraries' sines and sums: a few ulp
            np.testing.assert_allclose(found.gap, row["gap"], rtol=1e-6, atol=1e-13)


def test_the_exact_methods_agree_and_the_others_come_near(rows):
    """On every question where both arrive: 1e-6 for methods of a scenario's own optimum."""
    exact = {(r["scenario_id"], r["branch"]): r for r in rows if r["solver"] == "analytic"}
    for row in rows:
        other = exact[row["scenario_id"], row["branch"]]
        if row["gap"] is None or other["gap"] is None:
            continue
        off = abs(row["length"] - other["length"]) / max(other["length"], row["radius"])
        coarse = row["solver"] in ("turn-rate-qp", "heading-milp")
        assert off <= (0.05 if coarse else 1e-6), (row["solver"], row["label"], row["branch"])
