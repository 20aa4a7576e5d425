"""Scenarios as columns: the same bits as one by one, and those of numpy and scipy."""

from __future__ import annotations

import itertools
import math
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import qmc

from dubins_study.experiments.definition.axes import Log
from dubins_study.experiments.definition.scenario_block import Block
from dubins_study.experiments.plan.scenario_columns import (
    axis_values,
    block_size,
    columns,
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


@pytest.mark.parametrize("name", BLOCKS)
def test_one_by_one_they_are_the_columns(name):
    """Bit by bit, names included; and a name is what its definition says."""
    found = block(name)
    made = columns(found)
    single = list(scenarios(found, "b"))

    assert len(single) == block_size(found)
    rows = np.array([[getattr(s, n) for n in NUMBERS] for s in single])
    assert rows.tobytes() == np.stack([made[n] for n in NUMBERS], axis=1).tobytes()


def test_a_name_is_the_hash_of_doubles_and_label():
    """By hand, with another packing."""
    import hashlib

    scenario = Scenario(1, -0.0, 0.1, 3, 4, 2, label="ß")
    packed = b"".join(struct.pack("<d", v) for v in (1, -0.0, 0.1, 3, 4, 2, 1)) + "ß".encode()

    assert scenario_id(scenario) == hashlib.sha256(packed).hexdigest()[:16]
    assert scenario_id(scenario) != scenario_id(Scenario(1, 0.0, 0.1, 3, 4, 2, label="ß"))


def test_targets_are_those_of_the_scalar_formulas():
    """Distance and bearing, arc and margin: with `math`, number by number, to the last bit."""
    polar, made = block("polar"), columns(block("polar"))
    product = itertools.product(polar.radius, np.geomspace(0.1, 30, 9), polar.bearing)
    expected = [(R * d * math.cos(bearing), R * d * math.sin(bearing)) for R, d, bearing in product]
    assert list(zip(made["target_x"].tolist(), made["target_y"].tolist(), strict=True)) == expected

    made = columns(block("circular"))
    arcs = np.repeat(np.linspace(-3, 3, 20), 4)
    margins = np.tile([-1, -1e-3, 0.0, 2], 20)
    for x, y, arc, margin in zip(made["target_x"], made["target_y"], arcs, margins, strict=True):
        # the centre lies across the heading; the target at its polar angle
        side = math.copysign(1, arc)
        centre = 2.1 + side * math.pi / 2
        angle = centre + math.pi + arc
        r = 1 + margin
        assert x == pytest.approx(math.cos(centre) + r * math.cos(angle), abs=1e-14)
        assert y == pytest.approx(math.sin(centre) + r * math.sin(angle), abs=1e-14)


@given(st.floats(1e-9, 1e9), st.floats(1e-9, 1e9), st.integers(1, 50))
def test_logarithmic_axes_are_numpys(first, last, count):
    axis = Log(log=(first, last, count))

    assert axis_values(axis) == pytest.approx(np.geomspace(first, last, count), rel=1e-13)


def test_sobol_points_are_scipys():
    drawn = qmc.Sobol(2, rng=np.random.default_rng(7)).random(128)[:100]
    headings = columns(block("sobol"))["heading"]

    assert headings[::2].tobytes() == (-3 + drawn[:, 0] * 6).tobytes()
    assert headings[::2].tobytes() == headings[1::2].tobytes()
