"""Scenarios of a block, and their ids.

They are those of the scalar formulas, of numpy and of scipy.
"""

import itertools
import math
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import qmc

from dubins_study.experiments.definition.scenario_block import SPACINGS, Block
from dubins_study.experiments.plan.scenarios import (
    block_size,
    scenario_id,
    scenarios,
)
from dubins_study.study.scenario import NUMBERS, Scenario

SOBOL = {
    "method": "sobol",
    "count": 100,
    "seed": 7,
    "ranges": {"heading": {"linear": [-3, 3]}, "radius": {"log": [0.01, 100]}},
}
BLOCKS = {
    "product": {"target_x": {"linear": [-4, 4, 17]}, "target_y": [1, 2.5, 0], "heading": [0, 0.3]},
    "polar": {"distance": {"log": [0.1, 30, 9]}, "bearing": [0.1, -2, 3], "radius": [1, 0.3]},
    "circular": {"arc": {"linear": [-3, 3, 20]}, "margin": [-1, -1e-3, 0.0, 2], "heading": 2.1},
    "sobol": {"sample": SOBOL, "target_x": [3, -1], "target_y": 2},
    "latin": {"sample": SOBOL | {"method": "latin hypercube"}, "distance": 3, "bearing": [1, 2]},
    "one": {"target_x": 3, "target_y": 4, "label": "ä"},
}


def block(name):
    return Block.model_validate(BLOCKS[name])


def columns(name):
    """Columns of a block's scenarios, one a field."""
    questions = list(scenarios(block(name), "b"))
    return {field: np.array([getattr(s, field) for s in questions]) for field in NUMBERS}


@pytest.mark.parametrize("name", BLOCKS)
def test_a_block_has_as_many_scenarios_as_its_size_says(name):
    questions = list(scenarios(block(name), "b"))

    assert len(questions) == block_size(block(name))


def test_a_name_is_the_hash_of_doubles_and_label():
    """A name is the hash of doubles and label.

    The hash is computed by hand, with another packing.
    """
    import hashlib

    scenario = Scenario(1, -0.0, 0.1, 3, 4, 2, label="ß")
    packed = b"".join(struct.pack("<d", v) for v in (1, -0.0, 0.1, 3, 4, 2, 1)) + "ß".encode()

    assert scenario_id(scenario) == hashlib.sha256(packed).hexdigest()[:16]
    assert scenario_id(scenario) != scenario_id(Scenario(1, 0.0, 0.1, 3, 4, 2, label="ß"))


def test_targets_are_those_of_the_scalar_formulas():
    """Targets are those of the scalar formulas.

    They are given by distance and bearing, arc and margin, and computed with `math`, number by
    number, to the last bit.
    """
    polar = block("polar")
    numbers = columns("polar")
    product = itertools.product(polar.radius, np.geomspace(0.1, 30, 9), polar.bearing)
    expected = [(R * d * math.cos(bearing), R * d * math.sin(bearing)) for R, d, bearing in product]
    assert (
        list(zip(numbers["target_x"].tolist(), numbers["target_y"].tolist(), strict=True))
        == expected
    )

    numbers = columns("circular")
    arcs = np.repeat(np.linspace(-3, 3, 20), 4)
    margins = np.tile([-1, -1e-3, 0.0, 2], 20)
    for x, y, arc, margin in zip(
        numbers["target_x"], numbers["target_y"], arcs, margins, strict=True
    ):
        # the centre lies across the heading; the target at its polar angle
        side = math.copysign(1, arc)
        centre = 2.1 + side * math.pi / 2
        angle = centre + math.pi + arc
        r = 1 + margin
        assert x == pytest.approx(math.cos(centre) + r * math.cos(angle), abs=1e-14)
        assert y == pytest.approx(math.sin(centre) + r * math.sin(angle), abs=1e-14)


@given(st.floats(1e-9, 1e9), st.floats(1e-9, 1e9), st.integers(1, 50))
def test_logarithmic_axes_are_numpys(first, last, count):
    axis = {"log": [first, last, count]}
    model = Block.model_validate({"radius": axis, "target_x": 1, "target_y": 2})

    assert model.radius == pytest.approx(np.geomspace(first, last, count), rel=1e-13)


def test_sobol_points_are_scipys():
    points = qmc.Sobol(2, rng=np.random.default_rng(7)).random(128)[:100]
    headings = columns("sobol")["heading"]

    assert headings[::2].tobytes() == (-3 + points[:, 0] * 6).tobytes()
    assert headings[::2].tobytes() == headings[1::2].tobytes()


def test_a_route_has_an_id_of_its_own():
    """A route has an id of its own.

    Nothing is added to the hash of one leg with a free final heading; that of a route is computed
    by hand.
    """
    import hashlib

    plain = Scenario(1, 2, 0.1, 3, 4, 2, label="a")
    numbers = struct.pack("<7d", 1, 2, 0.1, 3, 4, 2, 1) + b"a"
    route = Scenario(1, 2, 0.1, 3, 4, 2, label="a", via=[(5, 6)], final_heading=7)
    packed = numbers + b"\xff" + struct.pack("<3d", 5, 6, 7)

    assert scenario_id(plain) == hashlib.sha256(numbers).hexdigest()[:16]
    assert scenario_id(route) == hashlib.sha256(packed).hexdigest()[:16]


def test_routes_and_final_headings_of_a_block():
    """Via points vary fastest, then the final heading."""
    model = Block.model_validate(
        {
            **{"target_x": 9, "target_y": [1, 2], "final_heading": ["0deg", 1]},
            "via": [[], [[3, 4]], [[5, 6], [7, 8]]],
        }
    )
    vias = ((), ((3, 4),), ((5, 6), (7, 8)))
    expected = [
        Scenario(target_x=9, target_y=y, final_heading=final, via=via)
        for y, final, via in itertools.product([1, 2], [0, 1], vias)
    ]

    assert list(scenarios(model, "b")) == expected
    assert block_size(model) == len(expected)


ROUTES = {"legs": [1, 4, 2], "spacing": "2R-4R", "count": 50, "seed": 3}


def test_sampled_routes():
    """Sampled routes follow their law.

    Legs are as long as their law says, uniformly; turned any way; of the radius and start.
    """
    routes = ROUTES | {"count": 500}
    model = Block.model_validate({"route": routes, "x": 5, "radius": [1, 3], "heading": "1deg"})
    questions = list(scenarios(model, "b"))
    lengths = [
        np.hypot(*np.diff(s.points, axis=0).T) / s.radius for s in questions if s.radius == 3
    ]
    spread = np.concatenate(lengths)
    turns = np.concatenate([np.arctan2(*np.diff(s.points, axis=0).T) for s in questions])

    assert len(questions) == block_size(model) == 2 * 3 * 500
    assert [s.legs for s in questions] == np.repeat([1, 4, 2], 1000).tolist()
    assert {(s.x, s.y, s.final_heading) for s in questions} == {(5, 0, None)}
    assert 2 <= spread.min() < 2.1 < 3.9 < spread.max() <= 4
    # four standard errors of a uniform law; every turn is there twice, of both radii
    assert abs(spread.mean() - 3) < 4 * 2 / math.sqrt(12 * spread.size)
    assert abs(np.exp(1j * turns).mean()) < 4 / math.sqrt(turns.size / 2)


def test_sampled_routes_are_the_same_for_every_count_and_final_heading():
    """More samples and final headings change no route.

    The first ones of a longer list are the same; of one leg too, which has no via points.
    """
    few = list(scenarios(Block.model_validate({"route": ROUTES | {"count": 5}}), "b"))
    sampled = Block.model_validate({"route": ROUTES | {"final_heading": "sampled"}})
    many = list(scenarios(sampled, "b"))
    other = list(scenarios(Block.model_validate({"route": ROUTES | {"seed": 4}}), "b"))

    chosen = [many[start + i] for start in (0, 50, 100) for i in range(5)]
    assert [s.points.tolist() for s in few] == [s.points.tolist() for s in chosen]
    assert not {s.via for s in few[5:]} & {s.via for s in other}
    assert few[0].via == ()
    finals = [s.final_heading for s in many]
    assert len(set(finals)) == 150
    assert min(finals) < 0.2 < 6 < max(finals) < 2 * math.pi


def test_numbers_of_legs_are_whole():
    """Numbers of legs are whole.

    Evenly spaced numbers are none; they were taken, and ended the run with a traceback.
    """
    with pytest.raises(ValueError, match=r"route\.legs\.0\n  Input should be a valid integer"):
        Block.model_validate({"route": ROUTES | {"legs": {"linear": [1, 4, 4]}}})


@pytest.mark.parametrize("name", SPACINGS)
def test_every_spacing_may_be_named(name):
    model = Block.model_validate({"route": ROUTES | {"spacing": name}})
    low, high = SPACINGS[name]
    lengths = [np.hypot(*np.diff(s.points, axis=0).T) for s in scenarios(model, "b")]

    assert name == f"{low:g}R-{high:g}R"
    assert low <= min(map(min, lengths)) <= max(map(max, lengths)) <= high * (1 + 1e-12)


def test_a_final_heading_may_be_sampled():
    """A final heading is sampled like other fields."""
    ranges = {"bearing": {"linear": [0, 6]}, "final_heading": {"linear": ["-90deg", "90deg"]}}
    sample = {"method": "sobol", "count": 64, "seed": 1, "ranges": ranges}
    questions = list(scenarios(Block.model_validate({"distance": 3, "sample": sample}), "b"))
    finals = [s.final_heading for s in questions]

    assert len(set(finals)) == 64
    assert -math.pi / 2 <= min(finals) < -1.5 < 1.5 < max(finals) <= math.pi / 2


TOURS = {"points": [3, 6], "density": ["1.5R", "8R"], "count": 40, "seed": 3}


def tours(**keys):
    return list(scenarios(Block.model_validate({"tour": TOURS | keys}), "b"))


def test_sampled_tours():
    """Sampled tours fill their squares.

    Start and points fill a square of their own, as wide as the density says, uniformly.
    """
    model = Block.model_validate({"tour": TOURS | {"count": 400}, "x": 5, "radius": [1, 3]})
    questions = list(scenarios(model, "b"))

    assert len(questions) == block_size(model) == 2 * 2 * 2 * 400
    assert [s.legs for s in questions] == np.repeat([3, 6], 1600).tolist()
    assert {(s.x, s.y, s.order, s.closed, s.final_heading) for s in questions} == {
        (5, 0, "free", False, None)
    }
    for n, density, radius in itertools.product([3, 6], [1.5, 8], [1, 3]):
        place = 1600 * (n == 6) + 800 * (density == 8) + (radius == 3)
        some = questions[place : place + 800 : 2]
        side = density * radius * math.sqrt(n)
        spread = np.array([np.ptp(s.points, axis=0) for s in some])
        # of n + 1 uniform points: the range has the mean n / (n + 2); four standard errors
        variance = 2 * n / ((n + 2) ** 2 * (n + 3))
        assert spread.max() < side
        assert abs(spread.mean() / side - n / (n + 2)) < 4 * math.sqrt(variance / spread.size)
    headings = np.array([s.heading for s in questions])
    assert 0 <= headings.min() < 0.1 < 6.2 < headings.max() < 2 * math.pi


def test_tours_with_other_ends_have_the_same_points():
    """Tours with other ends have the same points.

    A tour that is closed or ends at any point passes what is the target of the others.
    """
    to_target, anywhere, closed, free = (
        tours(),
        tours(end="any"),
        tours(closed=True),
        tours(heading="free"),
    )

    for one, other in zip(to_target, anywhere, strict=True):
        assert [*one.via, (one.target_x, one.target_y)] == [*other.via]
        assert other.target is None
        assert one.heading == other.heading
    assert [s.via for s in closed] == [s.via for s in anywhere]
    assert {s.closed for s in closed} == {True}
    assert {s.heading for s in free} == {None}
    assert [s.points.tolist() for s in free] == [s.points.tolist() for s in to_target]
    assert len({scenario_id(s) for s in [*to_target, *anywhere, *closed, *free]}) == 4 * 160


def test_denser_tours_are_smaller_ones_of_a_longer_list():
    """Denser tours are smaller ones of the list.

    The unit square is the same at every density. The first tours are those of a longer list,
    whatever its size.
    """
    few, many = tours(count=2), tours()
    sparse, dense = many[40], many[0]

    assert [few[i].points.tolist() for i in (0, 1, 2, 4)] == [
        many[i].points.tolist() for i in (0, 1, 40, 80)
    ]
    np.testing.assert_allclose(sparse.points / 8, dense.points / 1.5, rtol=1e-12, atol=1e-15)


def test_orders_ends_and_headings_of_a_block():
    """A block sets orders, ends and headings.

    What is free or left out is so in the scenario; a heading at a point is its third value.
    """
    via = [[1, 2], [3, 4, "90deg"], [5, 6, "free"]]
    model = Block.model_validate({"via": via, "order": "free", "heading": ["free", 0.5]})
    points = ((1, 2), (3, 4, math.pi / 2), (5, 6))
    back = Block.model_validate({"via": via, "closed": True, "heading": "free"})
    ends = Block.model_validate(
        {"via": via, "target_x": 9, "target_y": 1, "final_heading": ["free", "0deg"]}
    )

    assert list(scenarios(model, "b")) == [
        Scenario(via=points, order="free", heading=heading) for heading in (None, 0.5)
    ]
    assert list(scenarios(back, "b")) == [Scenario(via=points, closed=True, heading=None)]
    assert [s.final_heading for s in scenarios(ends, "b")] == [None, 0]


def test_what_older_scenarios_do_not_have_leaves_their_ids():
    """New fields leave the ids of older scenarios.

    By hand: order, end and headings follow after another byte that is in no UTF-8.
    """
    import hashlib

    nan = math.nan
    closed = Scenario(1, 2, None, radius=2, via=[(5, 6), (7, 8, 0.5)], order="free", closed=True)
    numbers = struct.pack("<7d", 1, 2, nan, nan, nan, 2, 1)
    points = b"\xff" + struct.pack("<4d", 5, 6, 7, 8)
    more = b"\xff" + struct.pack("<2?2d", True, True, nan, 0.5)
    given = Scenario(1, 2, 0.1, 3, 4, 2, via=[(5, 6)], order="given", closed=False)

    assert scenario_id(closed) == hashlib.sha256(numbers + points + more).hexdigest()[:16]
    assert scenario_id(given) == scenario_id(Scenario(1, 2, 0.1, 3, 4, 2, via=[(5, 6)]))


def test_frozen_problems_are_asked_as_their_routes():
    """Frozen problems are asked as their routes.

    A pattern stands for all problems that it matches, each a route with the name as label.
    """
    block = Block(frozen=["tube-5000-*", "time-50-survey-6"])

    asked = list(scenarios(block, "scenarios.0"))

    assert len(asked) == block_size(block) == 5
    assert {scenario.label.rsplit("-", 2)[0] for scenario in asked} > {"time-50"}
    assert all(scenario.via for scenario in asked)


LAWS = ("clusters", "survey rows", "roads", "gps")


def field(law, **changes):
    """Scenarios of a block of routes in a field."""
    route = {"legs": 40, "spacing": "2R-4R", "count": 3, "seed": 5, "field": law} | changes
    return list(scenarios(Block.model_validate({"route": route}), "b"))


@pytest.mark.parametrize("law", LAWS)
def test_points_of_a_field(law):
    """The seed draws the points of a field.

    No two fields of a seed, no two laws and no two points are alike.
    """
    routes = field(law)

    assert routes == field(law)
    assert routes[:2] == field(law, count=2)
    assert len({scenario_id(each) for each in (*routes, *field(law, seed=6))}) == 6
    for each in routes:
        assert each.legs == 40
        assert len(np.unique(each.points, axis=0)) == 41


@pytest.mark.parametrize("law", LAWS)
def test_the_spacing_is_the_unit_of_a_field(law):
    """The spacing is the unit of a field.

    With another spacing the same seed draws the same field, larger; so does a denser tour.
    """
    near, far = (field(law, spacing=spacing)[0].points for spacing in ("2R-4R", "4R-20R"))
    tour = {"points": 40, "density": ["3R"], "count": 1, "seed": 5, "field": law}
    [drawn] = scenarios(Block.model_validate({"tour": tour}), "b")

    np.testing.assert_allclose(far, 4 * near, rtol=1e-12)  # 12 R and 3 R
    np.testing.assert_allclose(drawn.points, near, rtol=1e-12)


def test_fields_are_what_they_are_called():
    """Fields are what they are called.

    Legs are in units of 3 R: of rows whole ones and turns, of a track about one, of blobs short.
    """
    legs = {
        law: np.concatenate([np.hypot(*np.diff(s.points, axis=0).T) / 3 for s in field(law)])
        for law in LAWS
    }
    rows = legs["survey rows"]
    across = rows[np.abs(rows - 1) > 1e-9]

    assert (np.abs(rows - 1) <= 1e-9).sum() > 60
    assert (across >= 0.5).all()
    assert (across < 1).all()
    assert np.abs(legs["gps"] - 1).max() < 0.7
    assert legs["roads"].max() < 2
    assert np.median(legs["clusters"]) < 0.6
    assert legs["clusters"].max() > 3


@pytest.mark.parametrize("law", LAWS)
def test_a_field_of_one_leg(law):
    """The smallest number of legs is drawn too."""
    assert [each.legs for each in field(law, legs=1)] == [1, 1, 1]
