"""The check over frames: what `verdict.judge` finds, for paths of at most two arcs as arrays.

`verdict_kernel` judges ordinary rows; `judge` itself judges the others, which are few.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dubins_study.study.check.two_arcs import PATH_WORDS
from dubins_study.study.check.verdict import COARSE, is_false, judge
from dubins_study.study.check.verdict_kernel import (
    ODD,
    REGIONS,
    VERDICTS,
    Arcs,
    Findings,
    Limits,
    judge_rows,
)
from dubins_study.study.closed_form.kernel import FIRST_TURN, LAST_TURN, WORDS, shortest_rows
from dubins_study.study.closed_form.kernel_compile import loop_input
from dubins_study.study.closed_form.kernel_words import NO_PATH, CodeArray, Rows, ScenarioArrays
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.path import CLAIMS, BoolArray, FloatArray, Paths
from dubins_study.study.rows.schema import Judgement
from dubins_study.study.scenario import NUMBERS, Scenario
from dubins_study.study.tolerances import Tolerances
from dubins_study.study.words import BRANCHES, Claim, Verdict

if TYPE_CHECKING:
    import pandas as pd

NO_WORD = NO_PATH
_DEFAULT = Tolerances()
_FALSE = np.array([[is_false(claim, verdict) for verdict in VERDICTS] for claim in CLAIMS])
_LONGER, _NONE_EXISTS = VERDICTS.index(Verdict.LONGER), VERDICTS.index(Verdict.NONE_EXISTS)


@dataclass(frozen=True, eq=False)
class FrameJudgement:
    """The judgements of n rows: arrays of shape (n,); NaN where `verdict.Judgement` has None.

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
    findings = Findings.empty(n)
    (k1, k2), (l1, l2) = loop_input(paths.curvature), loop_input(paths.length)
    arcs = Arcs(k1, l1, k2, l2)
    limits = Limits(tolerances.miss, tolerances.curvature, tolerances.gap, BRANCHES.index(branch))
    odd = judge_rows(n)(scenarios, best.length, arcs, limits, findings)
    if paths.returned is not None:
        findings.verdict[~paths.returned] = ODD
        odd += n
    result = FrameJudgement(
        **findings._asdict(),
        reference_word=best.word,
        travel_time=findings.length / columns["speed"],
        reference=best.length,
        false_claim=np.zeros(0, np.bool_),
        wrong_basin=_wrong_basins(arcs, best, findings, columns),
    )
    if odd:
        _judge_odd_rows(result, columns, paths, codes, branch, tolerances)
    # np.take is quicker than indexing where one claim holds for all rows
    one = isinstance(codes, int)
    false = np.take(_FALSE[codes], result.verdict) if one else _FALSE[codes, result.verdict]
    return replace(result, false_claim=false)


def _wrong_basins(
    arcs: Arcs, best: Rows, findings: Findings, columns: dict[str, FloatArray]
) -> BoolArray:
    """Longer paths whose turn is more than 1 rad from the shortest path's."""
    wrong = np.zeros(best.word.size, np.bool_)
    rows = np.flatnonzero(findings.verdict == _LONGER)
    if not rows.size:
        return wrong
    k1, l1, k2, l2 = (array[rows] for array in arcs)
    word = best.word[rows]
    turn = FIRST_TURN[word] * best.first[rows] + LAST_TURN[word] * best.second[rows]
    driven_turn, turn = k1 * l1 + k2 * l2, turn / columns["radius"][rows]
    # codes of `PATH_WORDS` and `WORDS` agree as far as the latter go
    another = (findings.gap[rows] > COARSE) & (findings.word[rows] != word)
    wrong[rows] = (np.abs(driven_turn - turn) > 1.0) | another
    # straight behind, the mirror image is as short: few rows turn like it, and fewer tie
    for row in rows[wrong[rows] & (np.abs(driven_turn + turn) <= 1.0)]:
        optimum = shortest(_scenario(columns, int(row)))
        words = () if optimum is None else optimum.words
        other = findings.gap[row] > COARSE and PATH_WORDS[findings.word[row]] not in words
        wrong[row] = len(words) < 2 or other
    return wrong


def _judge_odd_rows(
    result: FrameJudgement,
    columns: dict[str, FloatArray],
    paths: Paths,
    codes: int | NDArray[np.intp],
    branch: str,
    tolerances: Tolerances,
) -> None:
    for row in np.flatnonzero(result.verdict == ODD):
        scenario = _scenario(columns, int(row))
        claim = CLAIMS[codes if isinstance(codes, int) else codes[row]]
        path = paths.path(int(row), scenario)
        _write(result, int(row), judge(scenario, path, claim, branch, tolerances))


def _scenario(columns: dict[str, FloatArray], row: int) -> Scenario:
    numbers: dict[str, Any] = {name: float(column[row]) for name, column in columns.items()}
    return Scenario(**numbers)


def _write(result: FrameJudgement, row: int, judged: Judgement) -> None:
    result.verdict[row] = VERDICTS.index(judged.verdict)
    result.region[row] = REGIONS.index(judged.region)
    result.word[row] = NO_WORD if judged.word is None else PATH_WORDS.index(judged.word)
    result.reference_word[row] = (
        NO_WORD if judged.reference_word is None else WORDS.index(judged.reference_word)
    )
    result.wrong_basin[row] = judged.wrong_basin
    for name in ("length", "travel_time", "reference", "gap", "miss", "curvature_excess", "margin"):
        value = getattr(judged, name)
        getattr(result, name)[row] = np.nan if value is None else value
