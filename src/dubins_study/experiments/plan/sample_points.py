"""The points of a sample: quasi-random, or of a Latin hypercube."""

from __future__ import annotations

import warnings

import numpy as np

from dubins_study.experiments.definition.axes import LinearRange, Range
from dubins_study.experiments.definition.scenario_block import Sample
from dubins_study.study.path import FloatArray


def sampled(sample: Sample) -> dict[str, FloatArray]:
    """One array of shape (count,) for each sampled field; the same on every machine."""
    from scipy.stats import qmc  # takes half a second; most experiments have no sample

    engine = qmc.Sobol if sample.method == "sobol" else qmc.LatinHypercube
    points = engine(len(sample.ranges), rng=np.random.default_rng(sample.seed))
    with warnings.catch_warnings():
        # scipy warns if the number of points is not a power of 2, which is the author's choice
        warnings.simplefilter("ignore", UserWarning)
        unit = points.random(sample.count)
    ranges = sample.ranges.items()
    return {field: _scaled(unit[:, i], over) for i, (field, over) in enumerate(ranges)}


def _scaled(unit: FloatArray, over: Range) -> FloatArray:
    """Scale points of the unit interval to a range."""
    if isinstance(over, LinearRange):
        low, high = over.linear
        return low + unit * (high - low)
    low, high = over.log
    values: FloatArray = low * (high / low) ** unit
    return values
