"""Certificates over frames: what `certificate.certify` computes, for paths of at most two arcs.

`extremal_rows` measures rows of the words S, C, CS and CC at full rate. `extremal.measure`
measures the others, of which the closed form returns none. `enclosure_kernel` encloses the
reference lengths but for some in a thousand, which `enclosure.enclose` does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from dubins_study.study.check import two_arcs
from dubins_study.study.check.certificate import (
    BOUND_TOLERANCE,
    CUT_TOLERANCE,
    PMP_ROUNDING,
    PMP_TOLERANCE,
    is_false_bound,
)
from dubins_study.study.check.enclosure import Enclosure, enclose
from dubins_study.study.check.enclosure_kernel import bound_rows
from dubins_study.study.check.extremal import ABNORMAL, MEASURED, measure
from dubins_study.study.check.verdict_frame import VERDICTS, FrameJudgement
from dubins_study.study.closed_form.kernel import CodeArray, ScenarioArrays
from dubins_study.study.closed_form.kernel_compile import compiled, inlined, loop_input
from dubins_study.study.path import BoolArray, FloatArray, Path, Paths, drivable
from dubins_study.study.scenario import scenarios
from dubins_study.study.tolerances import Tolerances
from dubins_study.study.words import Proof, Verdict

if TYPE_CHECKING:
    import pandas as pd

_costates = inlined(two_arcs.costates)
_word_of = inlined(two_arcs.word_of)
for _called in two_arcs.CALLED:
    register_jitable(_called)


@compiled
def extremal_rows(
    heading: FloatArray,
    radius: FloatArray,
    curvature: FloatArray,
    length: FloatArray,
    measured: FloatArray,
    abnormal: NDArray[np.bool_],
) -> NDArray[np.bool_]:
    """Fill `measured` and `abnormal`; returns which rows are left, shape (n,).

    Args:
        heading: start headings (rad), shape (n,).
        radius: turning radii (length unit), shape (n,).
        curvature: shape (2, n), 1 / length unit.
        length: shape (2, n), length unit.
        measured: shape (7, n), rows as `study.check.extremal.MEASURED`.
        abnormal: shape (n,).
    """
    n = heading.size
    left = np.zeros(n, np.bool_)
    for i in range(n):
        R = radius[i]
        u1, u2 = curvature[0, i] * R, curvature[1, i] * R
        l1, l2 = length[0, i] / R, length[1, i] / R
        word = _word_of(u1, l1, u2, l2)
        if not word.named:
            left[i] = True
            continue
        nu0, rho, phi, H, margin, cut = _costates(word.turn1, word.first, word.turn2, word.second)
        abnormal[i] = nu0 < ABNORMAL
        scale = rho if abnormal[i] else rho / nu0
        # turned by the heading on its own: added to one of many turns, phi loses its digits
        c, s = math.cos(heading[i]), math.sin(heading[i])
        measured[0, i] = scale * (c * math.cos(phi) - s * math.sin(phi))
        measured[1, i] = scale * (s * math.cos(phi) + c * math.sin(phi))
        measured[2, i] = H
        measured[3, i] = margin
        measured[4, i] = 0.0
        measured[5, i] = max(H, -margin)
        measured[6, i] = cut
    return left


PROOFS = tuple(Proof)
_DEFAULT = Tolerances()
_PROVED, _BOUNDED, _EXTREMAL, _NONE = range(len(PROOFS))
_OPTIMAL, _NONE_EXISTS = map(VERDICTS.index, (Verdict.OPTIMAL, Verdict.NONE_EXISTS))


@dataclass(frozen=True, eq=False)
class FrameCertificate:
    """The certificates of n rows: arrays of shape (n,), NaN where `certify` returns None.

    `proof` indexes `PROOFS`. There are no multipliers to compare the costates with.
    """

    proof: CodeArray
    reference_low: FloatArray
    reference_high: FloatArray
    measured: FloatArray  # shape (7, n), rows as `study.check.extremal.MEASURED`
    abnormal: BoolArray
    false_bound: BoolArray

    @classmethod
    def empty(cls, n: int) -> FrameCertificate:
        """n rows without evidence and without proof."""
        low, high, *measured = np.full((2 + len(MEASURED), n), np.nan)
        flags = np.zeros((2, n), np.bool_)
        return cls(np.full(n, _NONE, np.uint8), low, high, np.array(measured), *flags)

    def columns(self) -> dict[str, FloatArray]:
        """The measured numbers by their names in `study.rows.schema`."""
        return dict(zip(MEASURED, self.measured, strict=True))


def certify_frame(
    frame: pd.DataFrame,
    paths: Paths,
    judged: FrameJudgement,
    branch: str = "best",
    lower_bound: FloatArray | None = None,
    tolerances: Tolerances = _DEFAULT,
) -> FrameCertificate:
    """Certify the judged paths of a frame.

    Args:
        frame: scenarios as `study.scenario.check_frame` returns them, n rows.
        paths: their paths, n rows.
        judged: their judgement by `study.check.verdict_frame.judge_frame`.
        branch: the branch that was asked, for all rows.
        lower_bound: bounds that the solver gives (length unit), shape (n,); NaN where none.
        tolerances: those of the judgement.
    """
    n = len(paths)
    certificate = FrameCertificate.empty(n)
    heading, radius = (loop_input(frame[name]) for name in ("heading", "radius"))
    curvature, length = map(loop_input, (paths.curvature, paths.length))
    odd = extremal_rows(
        heading, radius, curvature, length, certificate.measured, certificate.abnormal
    )
    if paths.returned is not None:
        odd &= paths.returned
        certificate.measured[:, ~paths.returned] = np.nan
    for row, scenario in zip(np.flatnonzero(odd), scenarios(frame[odd]), strict=True):
        _measure_row(certificate, int(row), paths.path(int(row), scenario), scenario.radius)
    open_rows = _enclose(certificate, frame, branch)
    _prove(certificate, judged, branch, lower_bound, tolerances, radius, open_rows)
    for bounds in (certificate.reference_low, certificate.reference_high):
        bounds[np.isinf(bounds)] = np.nan
    return certificate


def _enclose(
    certificate: FrameCertificate, frame: pd.DataFrame, branch: str
) -> dict[int, Enclosure]:
    """The proven interval around every reference length; returns the enclosures of open rows."""
    low, high = certificate.reference_low, certificate.reference_high
    arrays = ScenarioArrays(*(frame[name].to_numpy() for name in ScenarioArrays._fields))
    low[:], high[:], left = bound_rows(arrays, branch)
    open_rows = {}
    for row, scenario in zip(np.flatnonzero(left).tolist(), scenarios(frame[left]), strict=True):
        interval = enclose(scenario, branch)
        low[row], high[row] = interval.low, interval.high
        if interval.absent or len(interval.parts) > 1:
            open_rows[row] = interval
    return open_rows


def _measure_row(certificate: FrameCertificate, row: int, path: Path | None, radius: float) -> None:
    """Measure a row that the kernel leaves: of other pieces than S, C, CS and CC."""
    certificate.measured[:, row] = np.nan
    if path is None or not drivable(path):
        return
    best, cut = measure(path, radius)
    if best is not None:
        certificate.abnormal[row] = best.abnormal
        numbers = best.hamiltonian, best.sign_margin, best.transversality, best.residual
        certificate.measured[:-1, row] = (*best.nu, *numbers)
    certificate.measured[-1, row] = np.nan if cut is None else cut


def _prove(
    certificate: FrameCertificate,
    judged: FrameJudgement,
    branch: str,
    lower_bound: FloatArray | None,
    tolerances: Tolerances,
    radius: FloatArray,
    open_rows: dict[int, Enclosure],
) -> None:
    """The proof of every row, as `certificate._proof` decides it.

    Of the rows in `open_rows` the interval has several parts, or there may be no path.
    """
    low, high, numbers = (
        certificate.reference_low,
        certificate.reference_high,
        certificate.columns(),
    )
    with np.errstate(invalid="ignore"):
        scale = np.maximum(low, radius)
        allowed = tolerances.gap * scale
        bound = np.full(low.size, np.nan) if lower_bound is None else lower_bound
        arrives = np.isfinite(judged.gap)
        certificate.false_bound[:] = ~np.isnan(bound) & (bound > high + BOUND_TOLERANCE * scale)
        tolerance = PMP_TOLERANCE + PMP_ROUNDING * judged.length / radius
        is_extremal = (judged.length == 0) | (numbers["pmp_residual"] <= tolerance)
        near = (low - allowed <= judged.length) & (judged.length <= high + allowed)
        for row, interval in open_rows.items():
            near[row] = interval.holds(judged.length[row], allowed[row])
            certificate.false_bound[row] = is_false_bound(
                None if np.isnan(bound[row]) else bound[row],
                interval,
                scale[row],
                judged.length[row] if arrives[row] else None,
            )
        near &= arrives & (judged.verdict == _OPTIMAL) & np.isfinite(high)
        clear = (numbers["cut_margin"] >= -CUT_TOLERANCE) | (branch != "best")
        proved = near & ((is_extremal & clear) | (branch in ("LR", "RL")))
        bounded = near & ~certificate.false_bound & (np.abs(judged.length - bound) <= allowed)
        no_path = (judged.verdict == _NONE_EXISTS) & (low == np.inf)
    certificate.proof[arrives & is_extremal] = _EXTREMAL
    certificate.proof[bounded] = _BOUNDED
    certificate.proof[proved | no_path] = _PROVED
