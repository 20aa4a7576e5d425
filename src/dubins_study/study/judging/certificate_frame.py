"""Certificates over frames: what `certificate.certify` computes, for paths of two or three arcs.

Compiled loops measure and enclose nearly all rows. `extremal.measure` measures words that the
closed form never returns, and balls enclose some lengths in a thousand.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import BoolArray, CodeArray, FloatArray
from dubins_study.study.body_coordinates import EPS
from dubins_study.study.check import two_arcs
from dubins_study.study.check.certificate import BOUND_TOLERANCE, BY_INTERVAL, PROOFS, proof_levels
from dubins_study.study.check.enclosure_kernel import bound_rows
from dubins_study.study.check.extremal import MEASURED, measure
from dubins_study.study.closed_form.kernel import ScenarioArrays
from dubins_study.study.closed_form.kernel_compile import compiled, inlined, loop_input
from dubins_study.study.closed_form.pose_kernel import PoseArrays
from dubins_study.study.judging.verdict_frame import VERDICTS, FrameJudgement, three_arcs
from dubins_study.study.kinds.table import reference_of
from dubins_study.study.path import Paths, drivable
from dubins_study.study.scenario_frame import scenarios, with_final_headings
from dubins_study.study.tolerances import DEFAULT, Tolerances
from dubins_study.study.words import Proof, Verdict

if TYPE_CHECKING:
    import pandas as pd

_costates = inlined(two_arcs.costates)
_pose_costates, _nearest = inlined(two_arcs.pose_costates), inlined(two_arcs.nearest_rate)

_ROUNDED_RATES = 8.0 * EPS  # what rounding leaves of three rates
_NEXT_TO = 1e-6  # radii or rad, at least `two_arcs.NO_TURN` and `NO_LENGTH`
_OPTIMAL, _NONE_EXISTS = map(VERDICTS.index, (Verdict.OPTIMAL, Verdict.NONE_EXISTS))


class FrameCertificate(NamedTuple):
    """The certificates of n rows: arrays of shape (n,), NaN where `certify` returns None.

    `proof` indexes `PROOFS`. There are no multipliers to compare the costates with.
    """

    proof: CodeArray
    reference_low: FloatArray
    reference_high: FloatArray
    measured: FloatArray  # shape (7, n), rows as `study.check.extremal.MEASURED`
    abnormal: BoolArray
    false_bound: BoolArray

    def columns(self) -> dict[str, FloatArray]:
        """The measured numbers by their names in `study.rows.schema`."""
        return dict(zip(MEASURED, self.measured, strict=True))


def certify_frame(
    frame: pd.DataFrame,
    paths: Paths,
    judged: FrameJudgement,
    branch: str = "best",
    lower_bound: FloatArray | None = None,
    tolerances: Tolerances = DEFAULT,
) -> FrameCertificate:
    """Certify the judged paths of a frame.

    Args:
        frame: scenarios as `study.scenario_frame.check_frame` returns them, n rows.
        paths: their paths, n rows.
        judged: their judgement by `study.judging.verdict_frame.judge_frame`.
        branch: the branch that was asked, for all rows.
        lower_bound: bounds that the solver gives (length unit), shape (n,); NaN where none.
        tolerances: those of the judgement.
    """
    n = len(paths)
    measured, abnormal = np.full((len(MEASURED), n), np.nan), np.zeros(n, np.bool_)
    poses = with_final_headings(frame)
    radius = frame["radius"].to_numpy()
    _measure(frame, paths, poses, measured, abnormal)
    if poses:
        measured[:, ~np.isfinite(judged.gap)] = np.nan
        abnormal &= np.isfinite(judged.gap)
    kind = PoseArrays if poses else ScenarioArrays
    low, high, left = bound_rows(kind(*(frame[name].to_numpy() for name in kind._fields)), branch)
    intervals = {
        row: reference_of(scenario, branch).enclosure
        for row, scenario in zip(np.flatnonzero(left).tolist(), scenarios(frame[left]), strict=True)
    }
    for row, interval in intervals.items():
        low[row], high[row] = interval.low, interval.high
    bound = np.full(n, np.nan) if lower_bound is None else lower_bound
    length, arrives = judged.length, np.isfinite(judged.gap)
    with np.errstate(invalid="ignore"):
        scale = np.maximum(low, radius)
        allowed = tolerances.gap * scale
        near = (low - allowed <= length) & (length <= high + allowed) & np.isfinite(high)
        highest = high.copy()
        for row, interval in intervals.items():
            near[row] = interval.exists and interval.holds(length[row], allowed[row])
            highest[row] = interval.highest(length[row] if arrives[row] else None)
        false_bound = bound > highest + BOUND_TOLERANCE * scale
        levels = proof_levels(
            BY_INTERVAL if poses else branch,
            judged.verdict == _OPTIMAL,
            judged.verdict == _NONE_EXISTS,
            arrives,
            length,
            radius,
            measured[MEASURED.index("pmp_residual")],
            measured[MEASURED.index("cut_margin")],
            low,
            near,
            np.where(false_bound, np.nan, bound),
            allowed,
        )
    proof = np.full(n, PROOFS.index(Proof.NONE), np.uint8)
    for level in reversed(range(len(levels))):
        proof[levels[level]] = level
    for bounds in (low, high):
        bounds[np.isinf(bounds)] = np.nan
    return FrameCertificate(proof, low, high, measured, abnormal, false_bound)


def _measure(
    frame: pd.DataFrame, paths: Paths, poses: bool, measured: FloatArray, abnormal: BoolArray
) -> None:
    """Fill `measured` and `abnormal`, whose rows are NaN where nothing can be measured."""
    heading, radius = (loop_input(frame[name]) for name in ("heading", "radius"))
    left = _measure_rows(heading, radius, *three_arcs(paths), not poses, measured, abnormal)
    if paths.returned is not None:
        left &= paths.returned
        measured[:, ~paths.returned] = np.nan
    for row, scenario in zip(np.flatnonzero(left).tolist(), scenarios(frame[left]), strict=True):
        path = paths.path(row, scenario)
        if path is None or not drivable(path):
            continue
        best, cut = measure(path, scenario.radius, not poses)
        if best is not None:
            abnormal[row] = best.abnormal
            measured[:-1, row] = [getattr(best, name) for name in MEASURED[:-1]]
        measured[-1, row] = np.nan if cut is None else cut


@compiled
def _measure_rows(
    heading: FloatArray,
    radius: FloatArray,
    curvature: FloatArray,
    length: FloatArray,
    free: bool,
    measured: FloatArray,
    abnormal: BoolArray,
) -> BoolArray:
    """Measure rows of full rate: of S, C, CS and CC, or if headings are not free of CSC and CCC.

    Returns which rows are left: other words, those with an arc next to nothing and, of CCC, with a
    middle one next to half a turn, where the costates are abnormal, or next to a full one.

    Args:
        heading, radius: of the scenarios (rad, length unit), shape (n,).
        curvature, length: controls of their paths (1 / length unit, length unit), shape (3, n).
        measured: out, shape (7, n), rows as `study.check.extremal.MEASURED`.
        abnormal: out, shape (n,).
    """
    n = heading.size
    left = np.zeros(n, np.bool_)
    for i in range(n):
        R = radius[i]
        a, b, c = length[0, i] / R, length[1, i] / R, length[2, i] / R
        u, v, w = curvature[0, i] * R, curvature[1, i] * R, curvature[2, i] * R
        if free and a == 0.0:
            u, a, v, b = v, b, 0.0, 0.0
        turn1, turn2, turn3 = _nearest(u), _nearest(v), _nearest(w)
        clear = (0.0 < a + b + c < math.inf) & ((a == 0.0) | (a > _NEXT_TO))
        clear &= ((b == 0.0) | (b > _NEXT_TO)) & ((c == 0.0) | (c > _NEXT_TO))
        off = abs(u - turn1) + abs(v - turn2) + abs(w - turn3)
        clear &= off <= _ROUNDED_RATES  # False for NaN, which a maximum may pass over
        if free:
            straight = (turn2 == 0.0) & ((turn1 != 0.0) | (b == 0.0))
            word = (c == 0.0) & (straight | (turn1 * turn2 == -1.0))
        else:
            bent = (turn1 == -turn2) & (turn3 == -turn2) & (min(b - math.pi, TWO_PI - b) > _NEXT_TO)
            word = (turn1 * turn3 != 0.0) & ((turn2 == 0.0) | bent)
            word &= (a > 0.0) | (b > 0.0) | (turn1 == turn3)
        if not (clear & word):
            left[i] = True
            continue
        cut, transversality = math.nan, math.nan
        if free:
            x, y, abnormal[i], H, margin, cut = _costates(heading[i], turn1, a, turn2, b)
            transversality = 0.0
        else:
            x, y, abnormal[i], H, margin = _pose_costates(heading[i], turn1, a, turn2, b, turn3, c)
        # one by one: Numba compiles the assignment of a tuple to a column for two seconds
        values = x, y, H, margin, transversality, max(H, -margin), cut
        for row in range(len(values)):
            measured[row, i] = values[row]
    return left
