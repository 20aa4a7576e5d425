"""The quasi-random points of a sample, drawn window by window."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dubins_study.experiments.definition.axes import LinearRange, Range
from dubins_study.experiments.definition.experiment import ExperimentError
from dubins_study.experiments.definition.scenario_block import Sample
from dubins_study.study.path import FloatArray

# All points of a Latin hypercube are drawn at once, because each depends on their number.
MOST_LATIN = 2_000_000


class SamplePoints:
    """The points of a sample, drawn when they are asked for.

    Args:
        sample: what to draw; None for a block without a sample.
        key: the block's key in the experiment, for messages.

    Raises:
        ExperimentError: if a Latin hypercube has more than `MOST_LATIN` points.
    """

    def __init__(self, sample: Sample | None, key: str) -> None:
        self._sample = sample
        # Points in the unit cube: row i of `_drawn` is the point with number `_first + i`.
        self._first, self._drawn = 0, np.empty((0, len(sample.ranges) if sample else 0))
        self._sobol: Any = None
        if sample is not None and sample.method == "latin hypercube":
            if sample.count > MOST_LATIN:
                raise ExperimentError(
                    f"{key}: sample.count is {sample.count}; expected at most {MOST_LATIN} for "
                    "method 'latin hypercube', which is drawn whole: 'sobol' takes more"
                )
            from scipy.stats import qmc  # takes half a second; most experiments have no sample

            rng = np.random.default_rng(sample.seed)
            self._drawn = qmc.LatinHypercube(len(sample.ranges), rng=rng).random(sample.count)

    def at(self, index: NDArray[np.int64]) -> dict[str, FloatArray]:
        """The sampled fields at some points.

        Args:
            index: numbers of the points, from 0; shape (n,), ascending.

        Returns:
            One array of shape (n,) for each sampled field.
        """
        if self._sample is None:
            return {}
        if self._sample.method == "sobol":
            self._draw_sobol(self._sample, int(index[0]), int(index[-1]) + 1)
        unit = self._drawn[index - self._first]
        ranges = self._sample.ranges.items()
        return {field: _scaled(unit[:, i], over) for i, (field, over) in enumerate(ranges)}

    def _draw_sobol(self, sample: Sample, first: int, end: int) -> None:
        """Hold the points from `first` up to `end`, `end` not included.

        A Sobol sequence can only be drawn forward. Points that nobody needs are skipped; for points
        before `_first` the sequence starts again.
        """
        if self._sobol is None or first < self._first:
            from scipy.stats import qmc  # only where there is a sample

            rng = np.random.default_rng(sample.seed)
            self._sobol = qmc.Sobol(len(sample.ranges), rng=rng)
            self._first, self._drawn = 0, self._drawn[:0]
        next_point = self._first + len(self._drawn)
        if first > next_point:
            self._sobol.fast_forward(first - next_point)
            next_point = first
        kept = self._drawn[first - self._first :] if first < next_point else self._drawn[:0]
        with warnings.catch_warnings():
            # scipy warns if the number of points drawn is not a power of 2. The warning is wrong
            # here: a window is only a piece of the sample.
            warnings.simplefilter("ignore", UserWarning)
            more = [self._sobol.random(end - next_point)] if end > next_point else []
        self._first, self._drawn = first, np.concatenate([kept, *more])


def _scaled(unit: FloatArray, over: Range) -> FloatArray:
    """Scale points of the unit interval to a range."""
    if isinstance(over, LinearRange):
        low, high = over.linear
        return low + unit * (high - low)
    low, high = over.log
    values: FloatArray = low * (high / low) ** unit
    return values
