"""Judge frames of paths of up to three arcs.

The findings are those of `judge`, computed for whole arrays.

A compiled loop judges ordinary rows: those whose path has the closed form's word, its rates up to
rounding, and its length. A row without a path is ordinary too, unless it denies a path that the
closed form has. Any other row is marked `ODD`, and `judge` itself judges it. Next to an edge of a
word both agree as well: there the intervals of `judge` hold the lengths on both sides, and a row
that is ordinary here is optimal there.
"""

from __future__ import annotations

import math
from itertools import product
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import BoolArray, CodeArray, FloatArray
from dubins_study.study.check.verdict import ROUNDED, WORD, is_false
from dubins_study.study.check.visits import CUT
from dubins_study.study.closed_form.kernel import (
    CHUNK,
    LARGEST,
    NO_PATH,
    RATES,
    WORDS,
    chunk_from,
    shortest_rows,
    to_local,
    to_local_exactly,
)
from dubins_study.study.closed_form.kernel_compile import inlined, loop_input, threaded
from dubins_study.study.closed_form.kernel_math import LARGEST_ANGLE, sine_cosine
from dubins_study.study.closed_form.pose_kernel import SIDES, PoseArrays, pose_rows
from dubins_study.study.closed_form.shortest import REGIONS
from dubins_study.study.judging.judge import judge
from dubins_study.study.path import CLAIMS, Paths
from dubins_study.study.rows.schema import Judgement
from dubins_study.study.scenario import NUMBERS, Scenario
from dubins_study.study.scenario_frame import with_final_headings
from dubins_study.study.tolerances import DEFAULT, DRIVEN, HEADED, Tolerances, arrives
from dubins_study.study.words import DENIALS, Claim, Verdict

if TYPE_CHECKING:
    import pandas as pd

VERDICTS = tuple(Verdict)
ODD = 254  # verdict of a row that is left to the scalar check
NO_WORD = NO_PATH
# the words of up to three arcs; the first ones are those of `kernel.WORDS`
LEG_WORDS = (
    *WORDS,
    "SL",
    "SR",
    *("".join(word) for word in product("SLR", repeat=3) if word[0] != word[1] != word[2]),
)
TEXTS = {"verdict": VERDICTS, "region": REGIONS, "word": LEG_WORDS, "reference_word": LEG_WORDS}
_OPTIMAL, _NONE, _NONE_EXISTS = map(
    VERDICTS.index, (Verdict.OPTIMAL, Verdict.NONE, Verdict.NONE_EXISTS)
)
_FALSE = np.array([[is_false(claim, verdict) for verdict in VERDICTS] for claim in CLAIMS])
_DENIALS = list(map(CLAIMS.index, DENIALS))


def _number(value: float) -> float | None:
    """Number as a Python float; None for NaN."""
    if math.isnan(value):
        return None
    return float(value)


class FrameJudgement(NamedTuple):
    """Judgements of n rows, as arrays of shape (n,).

    NaN stands where `Judgement` has None. `verdict` indexes `VERDICTS`, `region` indexes `REGIONS`,
    `word` and `reference_word` index `LEG_WORDS`; `NO_WORD` where there is none.
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

    def row(self, row: int) -> Judgement:
        """Verdict, length and gap of one row.

        A row's certificate begins with them.
        """
        return Judgement(
            verdict=VERDICTS[self.verdict[row]],
            false_claim=bool(self.false_claim[row]),
            length=_number(self.length[row]),
            gap=_number(self.gap[row]),
        )

    @classmethod
    def empty(cls, n: int) -> FrameJudgement:
        """Arrays for n rows.

        The flags are False, so that no row is a wrong basin; all other values are still to be
        written.
        """
        codes = np.empty((4, n), np.uint8)
        numbers = np.empty((7, n))
        flags = np.zeros((2, n), bool)
        # in the order of the fields
        return cls._make([*codes[:3], *numbers[:6], *flags, codes[3], numbers[6]])


class _Best(NamedTuple):
    """Shortest paths of n rows."""

    word: CodeArray  # the word's rates are in row `first + word` of `_RATES`; or `NO_PATH`
    first: int  # `_FREE` or `_POSED`
    length: FloatArray  # length unit


class _Limits(NamedTuple):
    """Tolerances and rules for judging rows of a kind."""

    miss: float
    curvature: float
    gap: float
    rounded: float  # relative gap up to which a path is its own reference
    cut: float  # radii, or share of a shorter path; shorter segments have no letter


# The rates of three segments of each word: first the words to any heading, then those to a given
# one. `_FREE` and `_POSED` are the rows at which each kind begins.
_RATES = np.concatenate((RATES, SIDES))
_FREE = 0
_POSED = len(RATES)


def judge_frame(
    frame: pd.DataFrame,
    paths: Paths,
    claim: Claim | ArrayLike = Claim.NONE,
    branch: str = "best",
    tolerances: Tolerances = DEFAULT,
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
    if isinstance(claim, Claim):
        claim = CLAIMS.index(claim)
    codes = np.asarray(claim, np.intp)  # without an axis if one claim holds for all rows
    columns = {name: loop_input(frame[name]) for name in (*NUMBERS, "final_heading")}
    legs = PoseArrays(*(columns[name] for name in PoseArrays._fields))
    result = FrameJudgement.empty(n)
    curvatures, lengths = three_arcs(paths)
    free = not with_final_headings(frame)
    limits = _Limits(
        miss=tolerances.miss,
        curvature=tolerances.curvature,
        gap=tolerances.gap,
        rounded=ROUNDED,
        cut=CUT,
    )
    if free:
        limits = limits._replace(rounded=0.0, cut=0.0)
        best = _shortest_free(legs, branch, result)
    else:
        best = _shortest_posed(legs, branch, result)
    _name_rows(n, best, lengths, legs.radius, limits.cut, result.word)
    _judge_rows(n, legs, curvatures, lengths, free, best, limits, result)
    if paths.returned is not None:
        denied = np.isin(codes, _DENIALS) & (branch != "best")
        _judge_nothing(~paths.returned, denied, best, free, result)
    result = result._replace(travel_time=result.length / columns["speed"])
    row_codes = np.broadcast_to(codes, n)
    for row in np.flatnonzero(result.verdict == ODD).tolist():
        numbers: dict[str, Any] = {name: float(column[row]) for name, column in columns.items()}
        if free:
            del numbers["final_heading"]
        scenario = Scenario(**numbers, _radians=True)
        path = paths.path(row, scenario)
        _write(result, row, judge(scenario, path, CLAIMS[row_codes[row]], branch, tolerances))
    if not codes.ndim:  # np.take is quicker than indexing
        return result._replace(false_claim=np.take(_FALSE[codes], result.verdict))
    return result._replace(false_claim=_FALSE[codes, result.verdict])


def three_arcs(paths: Paths) -> tuple[FloatArray, FloatArray]:
    """Controls of paths as three arcs, shape (3, n).

    Returns curvatures and lengths. Paths of two arcs get a third one without length.
    """
    none = np.zeros((3 - len(paths.curvatures), len(paths)))
    return (
        loop_input(np.concatenate([paths.curvatures, none])),
        loop_input(np.concatenate([paths.lengths, none])),
    )


def _shortest_free(legs: PoseArrays, branch: str, result: FrameJudgement) -> _Best:
    """Shortest paths to any heading.

    `reference_word`, `region` and `margin` of `result` are filled.
    """
    rows = shortest_rows(*legs[:-1], branch=branch)
    result.reference_word[:] = rows.word
    _describe(legs.x.size, legs, result)
    return _Best(rows.word, _FREE, rows.length)


def _shortest_posed(legs: PoseArrays, branch: str, result: FrameJudgement) -> _Best:
    """Shortest paths to the final headings.

    `reference_word` of `result` is filled. Its `region` and `margin` are emptied: they exist only
    for free final headings.
    """
    rows = pose_rows(*legs, branch=branch)
    best = _Best(rows.word, _POSED, rows.length)
    segments = loop_input(rows.segments)
    _name_rows(legs.x.size, best, segments, legs.radius, CUT, result.reference_word)
    result.region.fill(NO_WORD)
    result.margin.fill(np.nan)
    return best


def _judge_nothing(
    gone: BoolArray, denied: Any, best: _Best, free: bool, result: FrameJudgement
) -> None:
    """Judge rows without a path, in place.

    `gone` is the mask of these rows. `denied` is the mask of rows that claim that the branch has no
    path. If the closed form has one for such a row, the row is left to `judge`.
    """
    unknown = np.where(best.word == NO_PATH, _NONE_EXISTS, ODD)
    result.verdict[gone] = np.where(denied, unknown, _NONE)[gone]
    result.word[gone] = NO_WORD
    for name in ("length", "gap", "miss", "curvature_excess"):
        getattr(result, name)[gone] = np.nan
    if free:
        result.reference[gone] = best.length[gone]
    else:
        result.reference[gone] = np.nan
        result.reference_word[gone] = NO_WORD


def _write(result: FrameJudgement, row: int, judgement: Judgement) -> None:
    """Write the judgement of one row into the arrays."""
    for name, texts in TEXTS.items():
        text = getattr(judgement, name)
        code = NO_WORD
        if text is not None:
            code = texts.index(text)
        getattr(result, name)[row] = code
    for name in set(FrameJudgement._fields) - {*TEXTS, "false_claim"}:
        value = getattr(judgement, name)
        if value is None:
            value = np.nan
        getattr(result, name)[row] = value


@inlined
def _chord(half: float, sine: float, length: float) -> float:
    """Chord of an arc.

    `half` is half of its turn (rad), `sine` the sine of that.
    """
    straight = half == 0.0
    ratio = sine / (1.0 if straight else half)
    return length * (1.0 if straight else ratio)


_arrives = inlined(arrives)


@inlined
def _region_and_margin(X: float, Y: float, delta: float) -> tuple[int, float]:
    """Region and margin of a target.

    The region is that of `shortest.region_of` as an index into `REGIONS`, the margin that of
    `shortest.margin_local`.
    """
    y = abs(Y)
    # w of the nearer turning circle, and -w of the other one
    near, far = y * (2.0 - y) - X * X, y * (2.0 + y) + X * X
    on_circle = (abs(near) <= delta) | (far <= delta)
    disc = 1 if Y >= 0.0 else 2
    elsewhere = 3 if on_circle else 0
    margin = abs(near) / (1.0 + math.sqrt(X * X + (y - 1.0) * (y - 1.0)))
    return disc if near > delta else elsewhere, margin


@threaded
def _describe(begin: int, end: int, legs: PoseArrays, result: FrameJudgement) -> None:
    """Fill `region` and `margin` of `result`.

    A chunk with a target next to an edge, or with a huge heading, is computed again exactly.
    """
    x, y, heading, tx, ty, radius, _ = legs
    region = result.region
    margin = result.margin
    for chunk in range(begin, end, CHUNK):
        low, high = chunk_from(chunk, end)
        near = 0
        for i in range(low, high):
            sine, cosine = sine_cosine(heading[i])
            X, Y, four_delta = to_local(x[i], y[i], sine, cosine, tx[i], ty[i], radius[i])
            region[i], margin[i] = _region_and_margin(X, Y, 0.0)
            side = abs(Y)
            near += min(abs(side * (2.0 - side) - X * X), side) <= four_delta
            near += abs(heading[i]) > LARGEST_ANGLE
        for i in range(low, high if near else low):  # the last ulp decides
            X, Y, delta = to_local_exactly(x[i], y[i], heading[i], tx[i], ty[i], radius[i])
            region[i], margin[i] = _region_and_margin(X, Y, delta)


# Place of a word in `LEG_WORDS`, by the word's code. `_name_rows` makes such codes: numbers in base
# 4 with a digit for each letter, 1 for S, 2 for L, 3 for R.
_CODES = np.zeros(64, np.uint8)
for _index, _word in enumerate(LEG_WORDS):
    _CODES[int(f"0{_word}".translate(str.maketrans("SLR", "123")), 4)] = _index


@threaded
def _name_rows(
    begin: int,
    end: int,
    best: _Best,
    lengths: FloatArray,
    radius: FloatArray,
    cut: float,
    names: CodeArray,
) -> None:
    """Write the words of paths into `names`.

    The words are those of `Kind.words_of`, as places in `LEG_WORDS`. The paths have the rates of
    the shortest ones; `lengths` are those of their segments, shape (3, n).
    """
    for i in range(np.uint64(begin), np.uint64(end)):  # no index counts from the end
        code = best.first + best.word[i] if best.word[i] != NO_PATH else 0
        total = lengths[0, i] + lengths[1, i] + lengths[2, i]
        name = 0
        length = 0.0
        for place in range(3):
            length += lengths[place, i]
            rate = _RATES[code, place]
            if place < 2 and rate == _RATES[code, place + 1]:
                continue  # one run with the next
            turns = (rate != 0.0) & (length > WORD * radius[i])
            visible = (length > cut * min(radius[i], total)) & (turns | (length > WORD * total))
            # 0 is no letter; a letter that repeats the last one is not written
            letter = ((2 if rate > 0.0 else 3) if turns else 1) if visible else 0
            name = name if letter == 0 or letter == name % 4 else 4 * name + letter
            length = 0.0
        names[i] = _CODES[name]


@threaded
def _judge_rows(
    begin: int,
    end: int,
    legs: PoseArrays,
    curvature: FloatArray,
    lengths: FloatArray,
    free: bool,
    best: _Best,
    limits: _Limits,
    result: FrameJudgement,
) -> None:
    """Judge rows against the closed form.

    `verdict` (optimal or `ODD`), `length`, `miss`, `curvature_excess`, `reference` and `gap` of
    `result` are filled. Each chunk is judged in three loops that can be vectorised. Before the last
    one, `gap` and `reference` hold the turn and the sum of all turns.
    """
    x, y, heading, tx, ty, radius, final = legs
    verdict = result.verdict
    length = result.length
    miss = result.miss
    excess = result.curvature_excess
    turn = result.gap
    turns = result.reference
    for chunk in range(begin, end, CHUNK):
        low, high = chunk_from(chunk, end)
        # drive the path to its end
        for i in range(low, high):
            driven = turned = forward = left = angle = 0.0
            for arc in range(3):
                half = 0.5 * curvature[arc, i] * lengths[arc, i]
                sine, _ = sine_cosine(half)
                sine_mean, cosine_mean = sine_cosine(turned + half)
                chord = _chord(half, sine, lengths[arc, i])
                forward += chord * cosine_mean
                left += chord * sine_mean
                turned += 2.0 * half
                angle += abs(2.0 * half)
                driven += lengths[arc, i]
            sine, cosine = sine_cosine(heading[i])
            off_x = x[i] + (forward * cosine - left * sine) - tx[i]
            off_y = y[i] + (forward * sine + left * cosine) - ty[i]
            miss[i] = math.sqrt(off_x * off_x + off_y * off_y)
            length[i] = driven
            turn[i] = turned
            turns[i] = angle
        # compare its rates with those of the closed form's word
        for i in range(low, high):
            word = best.word[i]
            most = 0.0
            usual = word != NO_PATH
            code = best.first + word if usual else 0
            for arc in range(3):
                u = curvature[arc, i] * radius[i]
                driven = lengths[arc, i]
                rate = _RATES[code, arc]
                off = abs(u - rate)
                most = max(most, off if driven > 0.0 else 0.0)
                usual &= (driven == 0.0) | ((driven > 0.0) & (off <= ROUNDED))
            excess[i] = most
            # until the last loop the verdict is a flag: whether the row is ordinary so far
            verdict[i] = usual & (most <= limits.curvature)
        # compare its end with the target, and its length with the shortest
        for i in range(low, high):
            R = radius[i]
            off = heading[i] + turn[i] - final[i]
            off -= TWO_PI * math.floor(off / TWO_PI + 0.5)
            blur = DRIVEN * (abs(heading[i] + turn[i]) + abs(final[i]) + length[i] / R)
            extent = abs(x[i]) + abs(y[i]) + abs(tx[i]) + abs(ty[i])
            usual = (max(abs(heading[i]), turns[i]) <= LARGEST_ANGLE) & (length[i] <= LARGEST)
            usual &= _arrives(miss[i], R, extent, length[i], limits.miss)
            usual &= (verdict[i] != 0) & (free | (abs(off) <= HEADED + blur))
            least = best.length[i] * (1.0 - limits.rounded)
            most = best.length[i] * (1.0 + limits.rounded)
            reference = max(least, min(most, length[i]))
            gap = (length[i] - reference) / max(reference, R)
            usual &= (length[i] >= least * (1.0 - ROUNDED)) & (gap <= limits.gap)
            verdict[i] = _OPTIMAL if usual else ODD
            result.reference[i] = reference
            result.gap[i] = gap
