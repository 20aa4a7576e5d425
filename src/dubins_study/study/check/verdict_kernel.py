"""The check over arrays: paths of two arcs driven and measured, as `verdict.judge` does.

A row that is out of the ordinary is not judged here but marked `ODD`: no path or a broken one,
shorter than the reference (which then has to be relaxed) or longer where the data leave the
reference open, no path exists, or an angle too large for the polynomials.
`study.check.verdict_frame` hands those to the scalar check.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from dubins_study.study.check import two_arcs
from dubins_study.study.check.verdict import ROUNDED
from dubins_study.study.closed_form.kernel import chunk_bounds, chunks, to_local
from dubins_study.study.closed_form.kernel_compile import inlined, separate, threaded
from dubins_study.study.closed_form.kernel_math import LARGEST_ANGLE, sine_cosine
from dubins_study.study.closed_form.kernel_words import CodeArray, ScenarioArrays, to_local_exactly
from dubins_study.study.path import FloatArray
from dubins_study.study.tolerances import arrives
from dubins_study.study.words import Verdict

VERDICTS = tuple(Verdict)
REGIONS = ("outside", "left disc", "right disc", "circle")
ODD = 254  # verdict of a row that is left to the scalar check
_OPTIMAL, _LONGER, _MISSES = (
    VERDICTS.index(v) for v in (Verdict.OPTIMAL, Verdict.LONGER, Verdict.MISSES)
)
_LARGEST = np.finfo(np.float64).max
# q below which, and 4 delta above which, delta may move a length by more than the gap's tolerance
_STEEP = 0.125
_BLURRED = 1e-7

BoolArray = NDArray[np.bool_]


class Arcs(NamedTuple):
    """Controls of paths of two arcs: arrays of shape (n,); an arc of no length is no arc."""

    first_curvature: FloatArray
    first_length: FloatArray
    second_curvature: FloatArray
    second_length: FloatArray


class Limits(NamedTuple):
    """Tolerances of `study.check.verdict`, and what the branch allows (see `_excess`)."""

    miss: float
    curvature: float
    gap: float
    branch: int


class Findings(NamedTuple):
    """What the check finds: arrays of shape (n,), units as in `study.rows.schema`."""

    length: FloatArray
    gap: FloatArray
    miss: FloatArray
    curvature_excess: FloatArray
    margin: FloatArray
    verdict: CodeArray
    word: CodeArray
    region: CodeArray

    @classmethod
    def empty(cls, n: int) -> Findings:
        """Room for n rows."""
        a, b, c, d, e = np.empty((5, n))
        p, q, r = np.empty((3, n), np.uint8)
        return cls(a, b, c, d, e, p, q, r)


@inlined
def _displacement(k1: float, l1: float, k2: float, l2: float) -> tuple[float, float]:
    """End of two arcs driven from the origin with heading 0 (`path.rollout`)."""
    half1, half2 = 0.5 * k1 * l1, 0.5 * k2 * l2
    sine1, cosine1 = sine_cosine(half1)
    sine2, _ = sine_cosine(half2)
    sine_mean, cosine_mean = sine_cosine(2.0 * half1 + half2)
    chord1, chord2 = _chord(half1, sine1, l1), _chord(half2, sine2, l2)
    return chord1 * cosine1 + chord2 * cosine_mean, chord1 * sine1 + chord2 * sine_mean


@inlined
def _chord(half: float, sine: float, length: float) -> float:
    straight = half == 0.0
    ratio = sine / (1.0 if straight else half)
    return length * (1.0 if straight else ratio)


@inlined
def _excess(k1: float, k2: float, l1: float, l2: float, branch: int) -> float:
    """`verdict.curvature_excess` of two arcs, in units of 1 / radius.

    `branch` indexes `shortest.BRANCHES`: 0 best, 1 LS, 2 RS, 3 LR, 4 RL.
    """
    if branch == 0:
        a = abs(k1) - 1.0 if l1 > 0.0 else 0.0
        b = abs(k2) - 1.0 if l2 > 0.0 else 0.0
        return max(max(a, b), 0.0)
    mirror = -1.0 if branch == 2 or branch == 4 else 1.0
    k1, k2 = k1 * mirror, k2 * mirror
    if branch <= 2:
        a = max(k1 - 1.0, -k1) if l1 > 0.0 else 0.0
        b = max(k2 - 1.0, -k2) if l2 > 0.0 else 0.0
        return max(max(a, b), 0.0)
    # how far each arc is from +1, and from -1; the switch may come before, between or after
    plus1, minus1 = (abs(k1 - 1.0), abs(k1 + 1.0)) if l1 > 0.0 else (0.0, 0.0)
    plus2, minus2 = (abs(k2 - 1.0), abs(k2 + 1.0)) if l2 > 0.0 else (0.0, 0.0)
    return min(min(max(minus1, minus2), max(plus1, minus2)), max(plus1, plus2))


_path_word = inlined(two_arcs.path_word)
_arrives = inlined(arrives)


@inlined
def _region_and_margin(X: float, Y: float, delta: float) -> tuple[int, float]:
    """`shortest.region_of` as an index into `REGIONS`, and `shortest.margin_local`."""
    y = abs(Y)
    near, far = y * (2.0 - y) - X * X, y * (2.0 + y) + X * X
    on_circle = (abs(near) <= delta) | (far <= delta)
    disc = 1 if Y >= 0.0 else 2
    elsewhere = 3 if on_circle else 0
    margin = abs(near) / (1.0 + math.sqrt(X * X + (y - 1.0) * (y - 1.0)))
    return disc if near > delta else elsewhere, margin


@inlined
def _edge(X: float, Y: float, four_delta: float) -> int:
    """Which edges a target is near: 1 a circle or the axis, 2 where a length is ill-conditioned."""
    y = abs(Y)
    w = y * (2.0 - y) - X * X
    q, far_q = 4.0 * (2.0 - y) + w, 8.0 + w  # 9 less the squared distances from both centres
    steep = (min(abs(q), abs(far_q)) <= _STEEP) | (four_delta > _BLURRED)
    return (1 if min(abs(w), y) <= four_delta else 0) | (2 if steep else 0)


@separate
def _finish_regions(chunk: int, scenarios: ScenarioArrays, findings: Findings) -> None:
    """Regions and margins of rows so near a circle that the last ulp decides."""
    x, y, heading, tx, ty, radius = scenarios
    low, high = chunk_bounds(chunk, x.size)
    for i in range(low, high):
        if findings.verdict[i] & 1:
            X, Y, delta = to_local_exactly(x[i], y[i], heading[i], tx[i], ty[i], radius[i])
            findings.region[i], findings.margin[i] = _region_and_margin(X, Y, delta)


@inlined
def _judge_chunk(
    chunk: int,
    scenarios: ScenarioArrays,
    reference: FloatArray,
    arcs: Arcs,
    limits: Limits,
    findings: Findings,
) -> int:
    """Judge one chunk of rows; returns how many are `ODD`."""
    x, y, heading, tx, ty, radius = scenarios
    curvature1, length1, curvature2, length2 = arcs
    low, high = chunk_bounds(chunk, x.size)
    length, gap, miss, excess, margin, verdict, word, region = findings
    odd = 0
    near = 0
    for i in range(low, high):
        sine, cosine = sine_cosine(heading[i])
        X, Y, four_delta = to_local(x[i], y[i], sine, cosine, tx[i], ty[i], radius[i])
        region[i], margin[i] = _region_and_margin(X, Y, 0.0)
        verdict[i] = _edge(X, Y, four_delta)  # until the verdict is known
        near += verdict[i] & 1
    if near:
        _finish_regions(chunk, scenarios, findings)
    for i in range(low, high):
        k1, k2, l1, l2 = curvature1[i], curvature2[i], length1[i], length2[i]
        u, v = _displacement(k1, l1, k2, l2)
        sine, cosine = sine_cosine(heading[i])
        off_x = x[i] + (u * cosine - v * sine) - tx[i]
        off_y = y[i] + (u * sine + v * cosine) - ty[i]
        miss[i] = math.sqrt(off_x * off_x + off_y * off_y)
        length[i] = l1 + l2
        word[i] = _path_word(k1, l1, k2, l2)
        odd += not (miss[i] <= _LARGEST)
    for i in range(low, high):
        k1, k2, l1, l2 = curvature1[i], curvature2[i], length1[i], length2[i]
        excess[i] = _excess(k1 * radius[i], k2 * radius[i], l1, l2, limits.branch)
        extent = abs(x[i]) + abs(y[i]) + abs(tx[i]) + abs(ty[i])
        close = _arrives(miss[i], radius[i], extent, length[i], limits.miss)
        misses = not (close & (excess[i] <= limits.curvature))
        relative = (length[i] - reference[i]) / max(reference[i], radius[i])
        gap[i] = math.nan if misses else relative
        arrives = _OPTIMAL if relative <= limits.gap else _LONGER
        angle = max(abs(heading[i]), abs(k1 * l1) + abs(k2 * l2))
        sound = (angle <= LARGEST_ANGLE) & (min(l1, l2) >= 0.0)
        sound = sound & (miss[i] <= _LARGEST) & (margin[i] <= _LARGEST) & (length[i] <= _LARGEST)
        usual = sound & (length[i] >= reference[i] * (1.0 - ROUNDED))
        usual = usual & ((relative <= limits.gap) | (verdict[i] == 0))
        verdict[i] = (_MISSES if misses else arrives) if usual else ODD
        odd += not usual
    return odd


@threaded
def judge_rows(
    scenarios: ScenarioArrays,
    reference: FloatArray,
    arcs: Arcs,
    limits: Limits,
    findings: Findings,
) -> int:
    """Judge all rows against their shortest lengths; returns 0 if none is `ODD`."""
    odd = 0
    for chunk in numba.prange(chunks(scenarios.x.size)):
        odd += _judge_chunk(chunk, scenarios, reference, arcs, limits, findings)
    return odd
