"""The check over frames: what `verdict.judge` finds, for paths of at most two arcs as arrays.

Compiled loops judge ordinary rows. A row that is out of the ordinary is marked `ODD`, and `judge`
itself judges it: no path or a broken one, shorter than the reference (which then has to be relaxed)
or longer where the rounding of the data leaves the reference undecided, no path exists, or an angle
too large for the polynomials.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numba
import numpy as np
from numpy.typing import ArrayLike

from dubins_study.study.check import two_arcs
from dubins_study.study.check.two_arcs import PATH_WORDS
from dubins_study.study.check.verdict import COARSE, ROUNDED, is_false, judge
from dubins_study.study.closed_form.kernel import (
    FIRST_TURN,
    LAST_TURN,
    NO_PATH,
    WORDS,
    CodeArray,
    Rows,
    ScenarioArrays,
    chunk_bounds,
    chunks,
    shortest_rows,
    to_local,
    to_local_exactly,
)
from dubins_study.study.closed_form.kernel_compile import inlined, loop_input, separate, threaded
from dubins_study.study.closed_form.kernel_math import LARGEST_ANGLE, sine_cosine
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.path import CLAIMS, BoolArray, FloatArray, Paths
from dubins_study.study.rows.schema import Judgement
from dubins_study.study.scenario import NUMBERS, Scenario
from dubins_study.study.tolerances import Tolerances, arrives
from dubins_study.study.words import BRANCHES, Claim, Verdict

if TYPE_CHECKING:
    import pandas as pd

VERDICTS = tuple(Verdict)
REGIONS = ("outside", "left disc", "right disc", "circle")
ODD = 254  # verdict of a row that is left to the scalar check
NO_WORD = NO_PATH
_TEXTS = {"verdict": VERDICTS, "region": REGIONS, "word": PATH_WORDS, "reference_word": WORDS}
_OPTIMAL, _LONGER, _MISSES = (
    VERDICTS.index(v) for v in (Verdict.OPTIMAL, Verdict.LONGER, Verdict.MISSES)
)
_FALSE = np.array([[is_false(claim, verdict) for verdict in VERDICTS] for claim in CLAIMS])
_LARGEST = np.finfo(np.float64).max
# q below which, and 4 delta above which, delta may move a length by more than the gap's tolerance
_STEEP = 0.125
_BLURRED = 1e-7
_DEFAULT = Tolerances()


class FrameJudgement(NamedTuple):
    """The judgements of n rows: arrays of shape (n,); NaN where `Judgement` has None.

    `verdict` indexes `VERDICTS`, `region` indexes `REGIONS`, `word` indexes `PATH_WORDS` and
    `reference_word` indexes `WORDS`; `NO_WORD` where there is no word.
    """

    verdict: CodeArray
    word: CodeArray
    reference_word: CodeArray
    length: FloatArray
    travel_time: FloatArray
    reference: FloatArray
    gap: FloatArray
    miss: FloatArray
    curvature_excess: FloatArray
    false_claim: BoolArray
    wrong_basin: BoolArray
    region: CodeArray
    margin: FloatArray


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


def judge_frame(
    frame: pd.DataFrame,
    paths: Paths,
    claim: Claim | ArrayLike = Claim.NONE,
    branch: str = "best",
    tolerances: Tolerances = _DEFAULT,
) -> FrameJudgement:
    """Judge one path a scenario, from its controls alone.

    Args:
        frame: scenarios as `check_frame` returns them, n rows.
        paths: their paths, n rows.
        claim: one for all rows, or indices into `CLAIMS`, shape (n,).
        branch: the branch that was asked, for all rows.
        tolerances: as for `judge`.
    """
    n = len(frame)
    if len(paths) != n:
        raise ValueError(f"there are {len(paths)} paths for {n} scenarios")
    codes = CLAIMS.index(claim) if isinstance(claim, Claim) else np.asarray(claim, np.intp)
    columns = {name: loop_input(frame[name]) for name in NUMBERS}
    scenarios = ScenarioArrays(*(columns[name] for name in ScenarioArrays._fields))
    best = shortest_rows(*scenarios, branch=branch)
    length, gap, miss, excess, margin = np.empty((5, n))
    verdict, word, region = np.empty((3, n), np.uint8)
    (k1, k2), (l1, l2) = loop_input(paths.curvature), loop_input(paths.length)
    arcs = Arcs(k1, l1, k2, l2)
    limits = Limits(tolerances.miss, tolerances.curvature, tolerances.gap, BRANCHES.index(branch))
    result = FrameJudgement(
        verdict=verdict,
        word=word,
        reference_word=best.word,
        length=length,
        travel_time=length,
        reference=best.length,
        gap=gap,
        miss=miss,
        curvature_excess=excess,
        false_claim=np.empty(n, np.bool_),
        wrong_basin=np.zeros(n, np.bool_),
        region=region,
        margin=margin,
    )
    odd = _judge_rows(n)(scenarios, arcs, limits, result)
    if paths.returned is not None:
        verdict[~paths.returned] = ODD
        odd += n
    result = result._replace(travel_time=length / columns["speed"])
    _find_wrong_basins(result, arcs, best, columns)
    if odd:
        for row in np.flatnonzero(verdict == ODD).tolist():
            scenario = _scenario(columns, row)
            asked = CLAIMS[codes if isinstance(codes, int) else codes[row]]
            judged = judge(scenario, paths.path(row, scenario), asked, branch, tolerances)
            _write(result, row, judged)
    # np.take is quicker than indexing where one claim holds for all rows
    one = isinstance(codes, int)
    false = np.take(_FALSE[codes], verdict) if one else _FALSE[codes, verdict]
    return result._replace(false_claim=false)


def _find_wrong_basins(
    result: FrameJudgement, arcs: Arcs, best: Rows, columns: dict[str, FloatArray]
) -> None:
    """Mark longer paths whose turn is more than 1 rad from the shortest path's."""
    rows = np.flatnonzero(result.verdict == _LONGER)
    if not rows.size:
        return
    k1, l1, k2, l2 = (array[rows] for array in arcs)
    word = best.word[rows]
    turn = FIRST_TURN[word] * best.first[rows] + LAST_TURN[word] * best.second[rows]
    driven_turn, turn = k1 * l1 + k2 * l2, turn / columns["radius"][rows]
    # codes of `PATH_WORDS` and `WORDS` agree as far as the latter go
    another = (result.gap[rows] > COARSE) & (result.word[rows] != word)
    wrong = result.wrong_basin
    wrong[rows] = (np.abs(driven_turn - turn) > 1.0) | another
    # straight behind, the mirror image is as short: few rows turn like it, and fewer tie
    for row in rows[wrong[rows] & (np.abs(driven_turn + turn) <= 1.0)].tolist():
        optimum = shortest(_scenario(columns, row))
        words = () if optimum is None else optimum.words
        other = result.gap[row] > COARSE and PATH_WORDS[result.word[row]] not in words
        wrong[row] = len(words) < 2 or other


def _scenario(columns: dict[str, FloatArray], row: int) -> Scenario:
    numbers: dict[str, Any] = {name: float(column[row]) for name, column in columns.items()}
    return Scenario(**numbers)


def _write(result: FrameJudgement, row: int, judged: Judgement) -> None:
    for name, texts in _TEXTS.items():
        text = getattr(judged, name)
        getattr(result, name)[row] = NO_WORD if text is None else texts.index(text)
    for name in set(FrameJudgement._fields) - {*_TEXTS, "false_claim"}:
        value = getattr(judged, name)
        getattr(result, name)[row] = np.nan if value is None else value


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
def _finish_regions(chunk: int, scenarios: ScenarioArrays, result: FrameJudgement) -> None:
    """Regions and margins of rows so near a circle that the last ulp decides."""
    x, y, heading, tx, ty, radius = scenarios
    low, high = chunk_bounds(chunk, x.size)
    for i in range(low, high):
        if result.verdict[i] & 1:
            X, Y, delta = to_local_exactly(x[i], y[i], heading[i], tx[i], ty[i], radius[i])
            result.region[i], result.margin[i] = _region_and_margin(X, Y, delta)


@inlined
def _judge_chunk(
    chunk: int,
    scenarios: ScenarioArrays,
    arcs: Arcs,
    limits: Limits,
    result: FrameJudgement,
) -> int:
    """Judge one chunk of rows; returns how many are `ODD`."""
    x, y, heading, tx, ty, radius = scenarios
    curvature1, length1, curvature2, length2 = arcs
    low, high = chunk_bounds(chunk, x.size)
    verdict, word, region = result.verdict, result.word, result.region
    length, gap, miss, margin = result.length, result.gap, result.miss, result.margin
    excess, reference = result.curvature_excess, result.reference
    odd = 0
    near = 0
    for i in range(low, high):
        sine, cosine = sine_cosine(heading[i])
        X, Y, four_delta = to_local(x[i], y[i], sine, cosine, tx[i], ty[i], radius[i])
        region[i], margin[i] = _region_and_margin(X, Y, 0.0)
        verdict[i] = _edge(X, Y, four_delta)  # until the verdict is known
        near += verdict[i] & 1
    if near:
        _finish_regions(chunk, scenarios, result)
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
def _judge_rows(
    scenarios: ScenarioArrays, arcs: Arcs, limits: Limits, result: FrameJudgement
) -> int:
    """Judge all rows against their shortest lengths; returns 0 if none is `ODD`."""
    odd = 0
    for chunk in numba.prange(chunks(scenarios.x.size)):
        odd += _judge_chunk(chunk, scenarios, arcs, limits, result)
    return odd
