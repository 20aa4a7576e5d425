"""The check over frames: what `verdict.judge` finds, for paths of two or three arcs as arrays.

Compiled loops judge ordinary rows. A row that is out of the ordinary is marked `ODD`, and `judge`
itself judges it: no path or a broken one, shorter than the reference (its own end's then counts) or
longer where the rounding of the data leaves the reference undecided, no path exists, or an angle
too large for the polynomials. With final headings ordinary paths are the shortest ones, and a row
without a path is if the compiled intervals tell whether one exists.
"""

from __future__ import annotations

import math
from itertools import product
from typing import TYPE_CHECKING, Any, NamedTuple

import numba
import numpy as np
from numpy.typing import ArrayLike

from dubins_study.study.check import two_arcs
from dubins_study.study.check.enclosure_kernel import Bounds
from dubins_study.study.check.pose_enclosure_kernel import bound_pose_rows
from dubins_study.study.check.reference import ROUNDED
from dubins_study.study.check.two_arcs import FULL_RATE, PATH_WORDS, WORD
from dubins_study.study.check.verdict import COARSE, is_false, judge
from dubins_study.study.check.visits import CUT
from dubins_study.study.closed_form.kernel import (
    FIRST_TURN,
    LAST_TURN,
    NO_PATH,
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
from dubins_study.study.closed_form.pose_kernel import SIDES, PoseArrays, PoseRows, pose_rows
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.path import CLAIMS, BoolArray, FloatArray, Paths
from dubins_study.study.rows.schema import Judgement
from dubins_study.study.scenario import NUMBERS, Scenario
from dubins_study.study.scenario_frame import with_final_headings
from dubins_study.study.tolerances import DRIVEN, HEADED, Tolerances, arrives
from dubins_study.study.words import BRANCHES, POSE_BRANCHES, Claim, Verdict

if TYPE_CHECKING:
    import pandas as pd

VERDICTS = tuple(Verdict)
REGIONS = ("outside", "left disc", "right disc", "circle")
ODD = 254  # verdict of a row that is left to the scalar check
NO_WORD = NO_PATH
# the words of three arcs; the first ones are those of two, and of `kernel.WORDS`
LEG_WORDS = (
    *PATH_WORDS,
    *("".join(word) for word in product("SLR", repeat=3) if word[0] != word[1] != word[2]),
)
_TEXTS = {"verdict": VERDICTS, "region": REGIONS, "word": LEG_WORDS, "reference_word": LEG_WORDS}
_OPTIMAL, _LONGER, _MISSES, _NONE, _NONE_EXISTS = (
    *(VERDICTS.index(v) for v in (Verdict.OPTIMAL, Verdict.LONGER, Verdict.MISSES)),
    *(VERDICTS.index(v) for v in (Verdict.NONE, Verdict.NONE_EXISTS)),
)
_FALSE = np.array([[is_false(claim, verdict) for verdict in VERDICTS] for claim in CLAIMS])
_INFEASIBLE = CLAIMS.index(Claim.INFEASIBLE)
_LARGEST, _TWO_PI = np.finfo(np.float64).max, 2 * math.pi
# q below which, and 4 delta above which, delta may move a length by more than the gap's tolerance
_STEEP = 0.125
_BLURRED = 1e-7
_DEFAULT = Tolerances()


class FrameJudgement(NamedTuple):
    """The judgements of n rows: arrays of shape (n,); NaN where `Judgement` has None.

    `verdict` indexes `VERDICTS`, `region` indexes `REGIONS`, `word` and `reference_word` index
    `LEG_WORDS`; `NO_WORD` where there is none.
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

    @classmethod
    def empty(cls, n: int) -> FrameJudgement:
        """Room for n rows, none of them a wrong basin."""
        codes, numbers, flags = (
            np.empty((4, n), np.uint8),
            np.empty((7, n)),
            np.zeros((2, n), np.bool_),
        )
        return cls._make([*codes[:3], *numbers[:6], *flags, codes[3], numbers[6]])


class Arcs(NamedTuple):
    """Controls of paths of two arcs: arrays of shape (n,); an arc of no length is no arc."""

    first_curvature: FloatArray
    second_curvature: FloatArray
    first_length: FloatArray
    second_length: FloatArray


class Limits(NamedTuple):
    """Tolerances of `study.check.verdict`, and the branch: 0 for `best`, else see `_excess`."""

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
    poses = with_final_headings(frame)
    names = (*NUMBERS, "final_heading") if poses else NUMBERS
    columns = {name: loop_input(frame[name]) for name in names}
    result = FrameJudgement.empty(n)
    if poses:
        _judge_poses(columns, paths, codes, branch, tolerances, result)
    else:
        result = _judge_targets(columns, paths, branch, tolerances, result)
    result = result._replace(travel_time=result.length / columns["speed"])
    for row in np.flatnonzero(result.verdict == ODD).tolist():
        scenario = _scenario(columns, row)
        asked = CLAIMS[codes if isinstance(codes, int) else codes[row]]
        path = paths.path(row, scenario)
        _write(result, row, judge(scenario, path, asked, branch, tolerances))
    # np.take is quicker than indexing where one claim holds for all rows
    one, verdict = isinstance(codes, int), result.verdict
    false = np.take(_FALSE[codes], verdict) if one else _FALSE[codes, verdict]
    return result._replace(false_claim=false)


def three_arcs(paths: Paths) -> tuple[FloatArray, FloatArray]:
    """Controls as of paths of three arcs, shape (3, n): the last may have no length."""
    none = np.zeros((3 - len(paths.curvatures), len(paths)))
    curvature, length = (np.concatenate([a, none]) for a in (paths.curvatures, paths.lengths))
    return loop_input(curvature), loop_input(length)


def _judge_targets(
    columns: dict[str, FloatArray],
    paths: Paths,
    branch: str,
    tolerances: Tolerances,
    result: FrameJudgement,
) -> FrameJudgement:
    """Judge paths of two arcs, whose final headings are free."""
    scenarios = ScenarioArrays(*(columns[name] for name in ScenarioArrays._fields))
    best = shortest_rows(*scenarios, branch=branch)
    arcs = Arcs(*loop_input(paths.curvatures), *loop_input(paths.lengths))
    limits = Limits(tolerances.miss, tolerances.curvature, tolerances.gap, BRANCHES.index(branch))
    result = result._replace(reference=best.length, reference_word=best.word)
    _judge_rows(len(paths))(scenarios, arcs, limits, result)
    if paths.returned is not None:
        result.verdict[~paths.returned] = ODD
    _find_wrong_basins(result, arcs, best, columns)
    return result


def _judge_poses(
    columns: dict[str, FloatArray],
    paths: Paths,
    codes: Any,
    branch: str,
    tolerances: Tolerances,
    result: FrameJudgement,
) -> None:
    """Judge paths of up to three arcs that are to end with a heading."""
    legs = PoseArrays(*(columns[name] for name in PoseArrays._fields))
    best, bounds = pose_rows(*legs, branch=branch), bound_pose_rows(legs, branch)
    word = POSE_BRANCHES.index(branch)
    limits = Limits(tolerances.miss, tolerances.curvature, tolerances.gap, word)
    _judge_pose_rows(len(paths))(legs, *three_arcs(paths), best, bounds, limits, result)
    result.region.fill(NO_WORD)
    result.margin.fill(np.nan)
    if paths.returned is not None:
        absent = bounds.low == math.inf
        verdicts = np.where(absent & (codes == _INFEASIBLE), _NONE_EXISTS, _NONE)
        gone = ~paths.returned
        result.verdict[gone] = np.where(bounds.left, ODD, verdicts)[gone]
        for array in (result.word, result.reference_word):
            array[gone] = NO_WORD
        for name in ("length", "reference", "gap", "miss", "curvature_excess"):
            getattr(result, name)[gone] = np.nan


def _find_wrong_basins(
    result: FrameJudgement, arcs: Arcs, best: Rows, columns: dict[str, FloatArray]
) -> None:
    """Mark longer paths whose turn is more than 1 rad from the shortest path's."""
    rows = np.flatnonzero(result.verdict == _LONGER)
    if not rows.size:
        return
    k1, k2, l1, l2 = (array[rows] for array in arcs)
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
) -> None:
    """Judge one chunk of rows."""
    x, y, heading, tx, ty, radius = scenarios
    curvature1, curvature2, length1, length2 = arcs
    low, high = chunk_bounds(chunk, x.size)
    verdict, word, region = result.verdict, result.word, result.region
    length, gap, miss, margin = result.length, result.gap, result.miss, result.margin
    excess, reference = result.curvature_excess, result.reference
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


@threaded
def _judge_rows(
    scenarios: ScenarioArrays, arcs: Arcs, limits: Limits, result: FrameJudgement
) -> None:
    """Judge all rows against their shortest lengths."""
    for chunk in numba.prange(chunks(scenarios.x.size)):
        _judge_chunk(chunk, scenarios, arcs, limits, result)


# `_named` writes a word in base 4, a digit for each letter
_CODES = np.zeros(64, np.uint8)
for _index, _word in enumerate(LEG_WORDS):
    _CODES[int(f"0{_word}".translate(str.maketrans("SLR", "123")), 4)] = _index


@inlined
def _named(word: int, first: float, middle: float, last: float, radius: float) -> int:
    """`verdict.words_of` of the segments of one of `WORDS6`, as an index of `LEG_WORDS`."""
    total = first + middle + last
    name = 0
    for place in range(3):
        length = first if place == 0 else middle if place == 1 else last
        rate = SIDES[word, place]
        turns = (rate != 0.0) & (length > WORD * radius)
        seen = (length > CUT * min(radius, total)) & (turns | (length > WORD * total))
        letter = ((2 if rate > 0.0 else 3) if turns else 1) if seen else 0
        name = name if letter == 0 or letter == name % 4 else 4 * name + letter
    return int(_CODES[name])


@inlined
def _judge_pose_chunk(
    chunk: int,
    legs: PoseArrays,
    curvature: FloatArray,
    lengths: FloatArray,
    best: PoseRows,
    bounds: Bounds,
    limits: Limits,
    result: FrameJudgement,
) -> None:
    """Judge one chunk of rows whose final headings are given.

    A path of the closed form's word, at full rate, is ordinary if it arrives and is the shortest.
    """
    x, y, heading, tx, ty, radius, final = legs
    low, end = chunk_bounds(chunk, x.size)
    for i in range(low, end):
        R, usual = radius[i], (best.word[i] < len(SIDES)) & (not bounds.left[i])
        word = best.word[i] if usual else 0
        length = turned = forward = left = excess = angle = 0.0
        for arc in range(3):
            k, driven, rate = curvature[arc, i], lengths[arc, i], SIDES[word, arc]
            off_rate = abs(k * R - rate) if driven > 0.0 else 0.0
            beyond = max(abs(k * R) - 1.0, 0.0) if driven > 0.0 else 0.0
            excess = max(excess, off_rate if limits.branch else beyond)
            usual &= (driven >= 0.0) & (off_rate <= FULL_RATE)
            half = 0.5 * k * driven
            sine, _ = sine_cosine(half)
            sine_mean, cosine_mean = sine_cosine(turned + half)
            chord = _chord(half, sine, driven)
            forward, left = forward + chord * cosine_mean, left + chord * sine_mean
            turned, length, angle = turned + 2.0 * half, length + driven, angle + abs(2.0 * half)
        sine, cosine = sine_cosine(heading[i])
        off_x = x[i] + (forward * cosine - left * sine) - tx[i]
        off_y = y[i] + (forward * sine + left * cosine) - ty[i]
        miss = math.sqrt(off_x * off_x + off_y * off_y)
        off = heading[i] + turned - final[i]
        off -= _TWO_PI * math.floor(off / _TWO_PI + 0.5)
        blur = DRIVEN * (abs(heading[i] + turned) + abs(final[i]) + length / R)
        extent = abs(x[i]) + abs(y[i]) + abs(tx[i]) + abs(ty[i])
        reference = max(bounds.low[i], min(bounds.high[i], length))
        gap = (length - reference) / max(reference, R)
        usual &= (max(abs(heading[i]), angle) <= LARGEST_ANGLE) & (length <= _LARGEST)
        usual &= _arrives(miss, R, extent, length, limits.miss) & (abs(off) <= HEADED + blur)
        usual &= (length >= bounds.low[i] * (1.0 - ROUNDED)) & (gap <= limits.gap)
        result.verdict[i] = _OPTIMAL if usual & (excess <= limits.curvature) else ODD
        result.word[i] = _named(word, lengths[0, i], lengths[1, i], lengths[2, i], R)
        result.reference_word[i] = _named(word, best.first[i], best.middle[i], best.last[i], R)
        result.length[i], result.reference[i], result.gap[i] = length, reference, gap
        result.miss[i], result.curvature_excess[i] = miss, excess


@threaded
def _judge_pose_rows(
    legs: PoseArrays,
    curvature: FloatArray,
    lengths: FloatArray,
    best: PoseRows,
    bounds: Bounds,
    limits: Limits,
    result: FrameJudgement,
) -> None:
    """Judge all rows against their proven intervals."""
    for chunk in numba.prange(chunks(legs.x.size)):
        _judge_pose_chunk(chunk, legs, curvature, lengths, best, bounds, limits, result)
