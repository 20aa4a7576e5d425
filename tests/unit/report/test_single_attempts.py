"""The sample of attempts in the page.

Tested are which attempts it has, how they are packed, and what they take.
"""

import gzip
import json
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from dubins_study.report.data.results import Results, load
from dubins_study.report.topics import single_attempts as section
from dubins_study.report.topics.single_attempts import WORST, arcs_of, packed, sample
from dubins_study.study.path import Path
from dubins_study.study.scenario import NUMBERS, Pose, Scenario
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import attempt, lost, write_folder

HOSTILE = "</script>\n'\"$(touch x) \u202e"


def arcs(number: int, radius: float = 2.0) -> Path:
    """A path of `number` alternating arcs.

    They turn from left to right.
    """
    curvature = np.linspace(1, -1, number) / radius
    return Path(Pose(1, 2, 0.3), curvature, np.linspace(0.1, 0.7, number))


def rows() -> list[dict[str, Any]]:
    """Rows of three solvers at thirty targets.

    Each is asked twice; every fifth answer misses by its number.
    """
    records = []
    for number in range(30):
        angle = 2 * math.pi * number / 30
        scenario = Scenario(
            *(1, 2, 0.3, 3 + 4 * math.cos(angle), 4 * math.sin(angle), 2),
            label=HOSTILE if number % 2 else "",
        )
        for solver in ("analytic", f"mine[{HOSTILE}]", "long"):
            wrong = solver != "analytic" and number % 5 == 0
            path: Any = "exact"
            if wrong or solver == "long":
                path = Path(scenario.start, [0.0], [number]) if wrong else arcs(40)
            records += [
                attempt(
                    scenario,
                    solver,
                    path=path,
                    claim=Claim.LOCAL if wrong or number % 3 else Claim.FAILED,
                    repeat=repeat,
                    scenario_id=f"{number * 7919 % 10007:08x}",
                    wall_s=math.pi * 10.0 ** (number - 22),
                    evaluations=number * 12345,
                    message=f"{HOSTILE} {number}",
                )
                for repeat in (0, 1)
            ]
    return records


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    return load([write_folder(tmp_path_factory.mktemp("rows") / "mine", "mine", rows())])


def unpacked(chosen: pd.DataFrame) -> dict[str, Any]:
    return json.loads(packed(chosen, {"more": 1}))


def test_every_value_comes_back(results: Results):
    """Every value comes back.

    Texts and scenarios come back exactly, measured numbers to four digits, null as null.
    """
    chosen = sample(results, 10**6)
    read = unpacked(chosen)
    columns = read["columns"]
    scenarios = read["scenarios"]

    assert read["more"] == 1
    assert read["count"] == len(chosen)
    for name in ("experiment", "solver", "branch", "verdict", "claim", "message", "word"):
        known = [None, *read["texts"][name]]
        texts = [known[code] for code in columns[name]]
        assert texts == chosen[name].replace({np.nan: None}).tolist()
    for name in (*NUMBERS, "label", "scenario_id"):
        values = [scenarios[name][place] for place in columns["scenario"]]
        assert values == chosen[name].tolist()
    for name in ("gap", "miss", "curvature_excess", "length", "wall_s"):
        numbers = np.array(columns[name], dtype=float)
        np.testing.assert_allclose(numbers, chosen[name].astype(float), rtol=5e-4)
    assert columns["evaluations"] == chosen["evaluations"].tolist()
    assert columns["false_claim"] == chosen["false_claim"].astype(int).tolist()


def test_via_points_and_final_headings_come_back(results, tmp_path):
    """Via points and final headings come back.

    They do where there are any; for the command that repeats the attempt.
    """
    plain = Scenario(target_x=3, target_y=1)
    questions = [
        plain,
        replace(plain, via=[(1, -2), (3, 0.1)]),
        replace(plain, final_heading=7),
        replace(plain, via=[(5, 6)], final_heading=-1),
    ]
    records = [lost(s, scenario_id=f"{number}") for number, s in enumerate(questions)]
    read = unpacked(sample(load([write_folder(tmp_path / "a", "a", records)]), 10))
    scenarios = read["scenarios"]

    assert scenarios["scenario_id"] == ["0", "1", "2", "3"]
    assert scenarios["via_x"] == [None, [1, 3], None, [5]]
    assert scenarios["via_y"] == [None, [-2, 0.1], None, [6]]
    assert scenarios["final_heading"] == [None, None, 7, -1]
    assert "via_x" not in unpacked(sample(results, 10))["scenarios"]


def test_paths_come_back_as_arcs(results: Results):
    """Paths come back as arcs.

    They have any number of arcs, to seven digits in turning radii; the page's JSON holds no
    infinity.
    """
    chosen = sample(results, 10**6)
    for row, found in zip(chosen.to_dict("records"), unpacked(chosen)["paths"], strict=True):
        expected = [row["curvatures"] * row["radius"], row["lengths"] / row["radius"]]
        np.testing.assert_allclose(np.array(found).T, expected, rtol=1e-6)

    assert chosen["curvatures"].str.len().max() == 40
    assert arcs_of(None, [], 1.0) is None
    assert arcs_of([np.inf, 1e308], [1.0, np.nan], 2.0) == [["Infinity", 0.5], ["Infinity", None]]


def test_the_worst_attempts_are_false_claims_before_longer_paths_before_misses(tmp_path):
    """The worst attempts come in order.

    False claims come before longer paths, and these before misses. There are ten different
    questions a solver, the worst first; compared with a plain sort.
    """
    level = {"longer": 3, "misses": 2, "none": 1}
    records = []
    for number in range(60):
        scenario = Scenario(target_x=3 + number, target_y=1)
        verdict = ("longer", "misses", "none", "optimal")[number % 4]
        records += [
            attempt(scenario, "mine", scenario_id=f"{number:08x}", repeat=repeat)
            | {
                "verdict": verdict,
                "false_claim": number in (7, 30, 31),
                "gap": (number * 37 % 61) / 10 if verdict in ("longer", "optimal") else None,
                "miss": (number * 17 % 61) / 10,
            }
            for repeat in (0, 1, 2)
        ]
    frame = pd.DataFrame(records)

    def badness(row: Any) -> tuple[Any, ...]:
        size = max(row.miss, 0 if row.gap != row.gap else row.gap)
        return 4 if row.false_claim else level.get(row.verdict, 0), size

    questions = frame[frame["repeat"] == 0]
    expected = sorted(questions.itertuples(), key=badness, reverse=True)[:WORST]

    folder = write_folder(tmp_path / "mine", "mine", records)
    ranked = sample(load([folder]), most=1)
    ranked = ranked[ranked["worst"] > 0].sort_values("worst")
    assert ranked["worst"].tolist() == list(range(1, WORST + 1))
    assert [badness(row) for row in ranked.itertuples()] == [badness(row) for row in expected]
    assert ranked["scenario_id"].is_unique


def test_every_stratum_has_points_at_the_same_scenarios(results: Results):
    """Every stratum has points at the same scenarios.

    However small the sample: of each solver, region and verdict it has those with the least
    hashes.
    """
    stratum = ["solver", "region", "verdict"]
    every = results.rows[results.rows["repeat"] == 0]
    small = sample(results, 40)
    spread = small[small["spread"]]

    assert len(spread) <= 40 < len(every)
    assert set(map(tuple, spread[stratum].to_numpy())) == set(map(tuple, every[stratum].to_numpy()))
    for _, stratum_rows in spread.groupby(stratum):
        key = dict(stratum_rows[stratum].iloc[0])
        same = every[(every[list(key)] == pd.Series(key)).all(axis=1)]
        ids = stratum_rows["scenario_id"].tolist()
        assert ids == sorted(same["scenario_id"])[: len(ids)]


def test_the_sample_shrinks_to_its_budget(results: Results, monkeypatch: pytest.MonkeyPatch):
    """The sample shrinks to its budget.

    The worst attempts stay; the text says how many of how many are shown.
    """
    monkeypatch.setattr(section, "_SIZES", (180, 100, 30, 10))
    whole = section.attempts_section(results)
    size = len(gzip.compress(_content(whole)))
    monkeypatch.setattr(section, "_MOST_BYTES", 4 / 3 * size - 1500)
    less = section.attempts_section(results)
    shown = json.loads(_content(less))["count"]

    assert "All 180 attempts" not in whole.text  # second repeats are left out
    assert len(gzip.compress(_content(less))) < size
    wrong = results.rows.groupby("solver")["verdict"].apply(lambda v: (v != "optimal").sum())
    assert wrong.clip(upper=WORST).sum() <= shown < json.loads(_content(whole))["count"]
    assert f"{shown} of the 180 attempts are shown" in less.text


def _content(shown: Any) -> bytes:
    (plot,) = (block for block in shown.blocks if block.name == "attempts")
    return plot.packed["attempts"]
