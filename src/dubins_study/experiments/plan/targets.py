"""Target positions from distance and bearing, or from an arc and a margin."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from dubins_study.experiments.definition.scenario_block import CIRCULAR, POLAR
from dubins_study.study.path import FloatArray
from dubins_study.study.scenario import NUMBERS


def target_columns(fields: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """The columns of `NUMBERS`; the target is computed where the fields give it in another way.

    Args:
        fields: start, radius, speed and target (see `definition.scenario_block.Block`), one array
            of shape (n,) each.
    """
    targets: dict[str, FloatArray] = {}
    if "distance" in fields:
        targets = _from_bearing(fields)
    if "arc" in fields:
        targets = _beside_circle(fields)
    columns = {**fields, **targets}
    return {name: columns[name] for name in NUMBERS}


def _from_bearing(fields: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    distance, bearing = (fields[name] for name in POLAR)
    length, direction = distance * fields["radius"], fields["heading"] + bearing
    return {
        "target_x": fields["x"] + length * _each(math.cos, direction),
        "target_y": fields["y"] + length * _each(math.sin, direction),
    }


def _beside_circle(fields: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """Targets at an angle along a turning circle and at a distance from it."""
    arc, margin = (fields[name] for name in CIRCULAR)
    r, side = 1 + margin, np.copysign(1.0, arc)
    half = _each(math.sin, arc / 2)
    # In the vehicle's frame and in radii. The offset to the side is 1 - r cos(arc), written so that
    # a small arc keeps its digits: 1 - cos(arc) = 2 sin^2(arc / 2).
    ahead = r * _each(math.sin, np.abs(arc))
    left = 2 * (half * half) - margin * _each(math.cos, arc)
    cos, sin = _each(math.cos, fields["heading"]), _each(math.sin, fields["heading"])
    R = fields["radius"]
    return {
        "target_x": fields["x"] + R * (ahead * cos - side * left * sin),
        "target_y": fields["y"] + R * (ahead * sin + side * left * cos),
    }


def _each(function: Callable[[float], float], values: FloatArray) -> FloatArray:
    """A function of `math` at every value: numpy's functions may differ between machines."""
    return np.fromiter(map(function, values.tolist()), np.float64, values.size)
