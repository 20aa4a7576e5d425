"""The sample of attempts that the page embeds: which, how they are packed, and what they take."""

from __future__ import annotations

import gzip
import json
import math
from typing import Any

import numpy as np
import pandas as pd
import pytest

from dubins_study.report.data.results import Results, load
from dubins_study.report.interactive import section
from dubins_study.report.interactive.packing import Packed, pack
from dubins_study.report.interactive.polylines import GRID, polylines
from dubins_study.report.interactive.sample import WORST, sample
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import attempt, write_folder

FOUR_DIGITS = 2.0**-15  # half a unit in the last of the 15 bits that are kept of a measured number
HOSTILE = "</script>\n'\"$(touch x) \u202e"


def arcs(number: int, radius: float = 2.0) -> Path:
    """A path that turns from left to right in `number` arcs."""
    curvature = np.linspace(1, -1, number) / radius
    return Path(Pose(1, 2, 0.3), curvature, np.linspace(0.1, 0.7, number))


def rows() -> list[dict[str, Any]]:
    """Three solvers at thirty targets, twice each; every fifth answer misses by its number."""
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


class Unpacked:
    """The packed attempts, read as the page's script reads them, but by other code."""

    def __init__(self, packed: Packed) -> None:
        self.header = json.loads(packed.header)
        self.arrays = {}
        for name, (kind, offset, count) in self.header["arrays"].items():
            size = int(kind[1:])
            planes = np.frombuffer(packed.arrays, "u1", size * count, offset).reshape(size, count)
            self.arrays[name] = np.ascontiguousarray(planes.T).view(f"<{kind}").ravel()

    def texts(self, name: str) -> list[str | None]:
        known = [None, *self.header["texts"][name]]
        return [known[code] for code in self.arrays[name]]

    def of_scenario(self, name: str) -> list[Any]:
        return [self.header["scenarios"][name][place] for place in self.arrays["scenario"]]


def test_every_value_comes_back(results: Results):
    """Texts and scenarios exactly, measured numbers to four digits, null as not a number."""
    chosen = sample(results.attempts, 10**6)
    read = Unpacked(pack(chosen, {"more": 1}))

    assert read.header["more"] == 1
    assert read.header["count"] == len(chosen)
    for name in ("experiment", "solver", "branch", "verdict", "claim", "message", "word"):
        assert read.texts(name) == chosen[name].replace({np.nan: None}).tolist()
    for name in ("x", "y", "heading", "target_x", "target_y", "radius", "speed", "scenario_id"):
        assert read.of_scenario(name) == chosen[name].tolist()
    assert read.of_scenario("label") == chosen["label"].tolist()
    for name in ("gap", "miss", "curvature_excess", "length", "wall_s"):
        expected = chosen[name].astype(float).to_numpy()
        np.testing.assert_allclose(read.arrays[name], expected, rtol=FOUR_DIGITS, atol=1e-37)
    assert read.arrays["evaluations"].tolist() == chosen["evaluations"].tolist()
    flags = read.arrays["flags"]
    assert ((flags & 1) == 1).tolist() == chosen["false_claim"].tolist()


def test_short_paths_come_back_as_their_controls(results: Results):
    """In units of the radius, to the digits of numbers of 32 bits."""
    chosen = sample(results.attempts, 10**6)
    read = Unpacked(pack(chosen, {}))
    short = chosen["arcs"].between(1, 3)
    expected = chosen[short]
    turns = np.concatenate(
        [row[: row.notna().sum()] for _, row in expected[["k1", "k2", "k3"]].iterrows()]
    )
    drives = np.concatenate(
        [row[: row.notna().sum()] for _, row in expected[["l1", "l2", "l3"]].iterrows()]
    )

    assert short.sum() > 50
    assert read.arrays["arcs"].tolist() == chosen["arcs"].where(short, 0).tolist()
    np.testing.assert_allclose(read.arrays["turns"], 2 * turns, rtol=2.0**-23)
    np.testing.assert_allclose(read.arrays["drives"], drives / 2, rtol=2.0**-23)


def test_long_paths_come_back_as_points_of_the_path(results: Results):
    """From the start to the end, each point within a grid's step of the path."""
    chosen = sample(results.attempts, 10**6)
    read = Unpacked(pack(chosen, {}))
    path = arcs(40)
    along = path.at(np.linspace(0, path.total_length, 100_001))[:, :2]
    steps = read.arrays["steps"].reshape(2, -1).T.astype(int)
    first = np.append(0, np.cumsum(read.arrays["points"].astype(int)))
    boxes = read.arrays["boxes"].reshape(-1, 3)
    drawn = np.flatnonzero(read.arrays["points"])

    assert len(drawn) == len(boxes) == (chosen["arcs"] > 3).sum() > 20
    for box, row in zip(boxes[:3], drawn[:3], strict=True):
        places = np.cumsum(steps[first[row] : first[row + 1]], axis=0)
        points = box[:2] + box[2] * places
        assert places.min() == 0
        assert places.max() == GRID
        distance = np.hypot(*(points[:, None] - along[None]).transpose(2, 0, 1)).min(axis=1)
        assert distance.max() <= box[2]
        assert np.hypot(*(points[0] - along[0])) <= box[2]
        assert np.hypot(*(points[-1] - along[-1])) <= box[2]


def test_points_lie_close_where_a_path_turns():
    """Chords of the drawn points are never further from an arc than 0.3 % of its radius."""
    radius = 3.0
    lines = polylines(np.zeros((1, 3)), np.full((1, 4), 1 / radius), np.full((1, 4), radius))
    points = lines.boxes[0, :2] + lines.boxes[0, 2] * lines.places
    middles = (points[1:] + points[:-1]) / 2
    sagitta = radius - np.hypot(middles[:, 0], middles[:, 1] - radius)

    assert lines.counts[0] < 40
    # 0.15^2 / 8 of the radius, and two roundings to the grid
    assert sagitta.max() <= radius * 0.15**2 / 8 + 2 * lines.boxes[0, 2]


@pytest.mark.parametrize(
    ("curvature", "length"),
    [(1.0, -1.0), (1e308, 1e308), (0.0, 1e308), (1e200, 1e200), (0.0, np.inf), (np.nan, 1.0)],
)
def test_a_path_that_cannot_be_drawn_spoils_no_other(curvature: float, length: float):
    """It has no points; the path beside it has those that it has alone."""
    one = np.zeros((1, 3)), np.full((1, 5), 0.5), np.ones((1, 5))
    bad = np.full((1, 5), curvature), np.full((1, 5), length)
    alone = polylines(*one)
    both = polylines(
        np.zeros((2, 3)), *(np.vstack([b, o]) for b, o in zip(bad, one[1:], strict=True))
    )

    assert both.counts.tolist() == [0, alone.counts[0]]
    np.testing.assert_array_equal(both.places, alone.places)


def test_a_path_of_no_length_is_a_point():
    """All points of it lie at its start."""
    lines = polylines(np.array([[3.0, 4.0, 1.0]]), np.ones((1, 4)), np.zeros((1, 4)))

    assert lines.boxes[0, :2].tolist() == [3.0, 4.0]
    assert not lines.places.any()


def test_the_worst_attempts_are_false_claims_before_longer_paths_before_misses(tmp_path):
    """Ten different questions a solver, the worst first; compared with a plain sort."""
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
    ranked = sample(load([folder]).attempts, most=1)
    ranked = ranked[ranked["worst"] > 0].sort_values("worst")
    assert ranked["worst"].tolist() == list(range(1, WORST + 1))
    assert [badness(row) for row in ranked.itertuples()] == [badness(row) for row in expected]
    assert ranked["scenario_id"].is_unique


def test_every_stratum_has_points_at_the_same_scenarios(results: Results):
    """However small the sample: of each solver, region and verdict those with the least hashes."""
    stratum = ["solver", "region", "verdict"]
    every = results.rows[results.rows["repeat"] == 0]
    small = sample(results.attempts, 40)
    spread = small[small["spread"]]

    assert len(spread) <= 40 < len(every)
    assert set(map(tuple, spread[stratum].to_numpy())) == set(map(tuple, every[stratum].to_numpy()))
    for _, stratum_rows in spread.groupby(stratum):
        key = dict(stratum_rows[stratum].iloc[0])
        same = every[(every[list(key)] == pd.Series(key)).all(axis=1)]
        ids = stratum_rows["scenario_id"].tolist()
        assert ids == sorted(same["scenario_id"])[: len(ids)]


def test_the_sample_shrinks_to_its_budget(results: Results, monkeypatch: pytest.MonkeyPatch):
    """The worst attempts stay; the text says how many of how many are shown."""
    monkeypatch.setattr(section, "_FEWEST_POINTS", 10)
    whole = section.attempts_section(results)
    size = sum(len(gzip.compress(each)) for each in _content(whole))
    monkeypatch.setattr(section, "_MOST_BYTES", 4 / 3 * size - 1500)
    less = section.attempts_section(results)
    shown = Unpacked(Packed(*_content(less))).header["count"]

    assert "All 180 attempts" not in whole.text  # second repeats are left out
    assert sum(len(gzip.compress(each)) for each in _content(less)) < size
    assert 3 * WORST <= shown < Unpacked(Packed(*_content(whole))).header["count"]
    assert f"Shown are {shown} of the 180 attempts" in less.text


def _content(shown: Any) -> tuple[bytes, bytes]:
    packed = shown.blocks[0].packed
    return packed["attempts"], packed["attempts-header"]
