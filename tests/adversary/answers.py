"""Any answer before the check: verdict, proof and certificate, beside where its path truly ends."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from flint import acb, arb

from dubins_study.study.check.certificate import certify
from dubins_study.study.check.verdict import judge
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Certificate, Judgement
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import Tolerances
from dubins_study.study.words import Proof, Verdict
from tests.adversary.checks import outside
from tests.adversary.oracle import greatest, side
from tests.adversary.table import Table, paste_path
from tests.adversary.truth import Truth

_EPS = math.ulp(1.0)
_CLOSE = 1 + 1e-9  # what two computations of one tolerance may differ by
_SPREAD = 8  # how much wider than the sampled truth the whole truth may be
TOLERANCES = Tolerances()


def excess(rates: Sequence[float], branch: str) -> float:
    """Largest violation of what a branch allows of rates (curvature times radius)."""
    if branch == "best":
        return max((abs(u) - 1 for u in rates), default=0.0)
    first = 1 if branch[0] == "L" else -1
    if branch[1] == "S":
        return max((max(-u * first, u * first - 1) for u in rates), default=0.0)
    switches = range(len(rates) + 1)
    return min(
        max((abs(u - (first if i < n else -first)) for i, u in enumerate(rates)), default=0.0)
        for n in switches
    )


def answer(
    table: Table,
    scenario: Scenario,
    branch: str,
    path: Path,
    truth: Truth,
    end: acb | None,
    rng: np.random.Generator,
) -> tuple[Judgement, Certificate]:
    """Any answer: verdict, proof and certificate, against where the path ends and how long it is.

    `end` is the path's end in 60 digits, None if it cannot be driven.
    """
    judged = judge(scenario, path, branch=branch)
    certificate = certify(scenario, path, judged, branch)

    line = f"{paste_path(scenario, branch, path)}  # {judged.verdict}, {certificate.proof}"
    if end is None:
        evidence = certificate.pmp_residual, certificate.cut_margin
        table.note("broken path", judged.verdict is not Verdict.MISSES, line)
        table.note("broken path", any(number is not None for number in evidence), line)
        return judged, certificate
    arrives = _arrives(scenario, branch, path, truth, end)
    found = judged.verdict in (Verdict.OPTIMAL, Verdict.LONGER)
    if arrives is not None:
        table.note("arrival", found != arrives, line)
    length = _Length(truth, branch, scenario, path.total_length)
    if found:
        if length.wrong and judged.verdict is Verdict.OPTIMAL:
            truth.refine(rng)
            length = _Length(truth, branch, scenario, path.total_length)
        _verdict(table, judged, length, line)
    wrong = certificate.proof is Proof.PROVED and (arrives is False or length.wrong)
    table.note("proved", wrong, line)
    _certificate(table, scenario, path, certificate, end, line)
    return judged, certificate


def _arrives(scenario: Scenario, branch: str, path: Path, truth: Truth, end: acb) -> bool | None:
    """Whether a path is admissible and meets the target; None where rounding leaves that open."""
    R = scenario.radius
    if truth.exact[branch] is None:
        return None  # an admissible path of other pieces may arrive where the word itself does not
    controls = zip(path.curvature.tolist(), path.length.tolist(), strict=True)
    bend = excess([k * R for k, s in controls if s > 0], branch)
    if abs(bend - TOLERANCES.curvature) < 1e-14:
        return None
    miss = float(abs(end - truth.target))
    rounding = 32 * _EPS * (scenario.extent + path.total_length) / R
    if miss > TOLERANCES.miss * _CLOSE + 2 * rounding:
        return False
    if miss >= TOLERANCES.miss / _CLOSE or rounding > 0.5:
        return None
    return bend <= TOLERANCES.curvature


class _Length:
    """How a length compares with the sampled truth, of which the whole truth is hardly wider."""

    def __init__(self, truth: Truth, branch: str, scenario: Scenario, length: float) -> None:
        value = arb(length) / arb(scenario.radius)
        hulls = truth.hulls(branch)
        below = [value if side(high - value) >= 0 else high for low, high in hulls if low <= value]
        self.below = bool(below)
        reference = greatest(below) if below else value
        scale = float(greatest((reference, arb(1))))
        # a length that is hardly below some of the truth is as right as one that is hardly above
        apart = min(float(value - reference) if below else math.inf, float(outside(value, hulls)))
        room = _SPREAD * max((float(high - low) for low, high in hulls), default=0.0)
        self.right = apart <= TOLERANCES.gap * scale / _CLOSE
        self.wrong = apart > TOLERANCES.gap * scale * _CLOSE + room


def _verdict(table: Table, judged: Judgement, length: _Length, line: str) -> None:
    """Optimal if the length is in the truth, longer if it is not; below all of it, either."""
    if length.below:
        optimal = judged.verdict is Verdict.OPTIMAL
        table.note("verdict", length.wrong if optimal else length.right, line)


def _certificate(
    table: Table,
    scenario: Scenario,
    path: Path,
    certificate: Certificate,
    end: acb,
    line: str,
) -> None:
    """A path that satisfies Pontryagin and stays clear of its cut is shortest to its own end.

    Looked at in the path's own neighbourhood, as wide as the check lets a path miss.
    """
    residual, cut = certificate.pmp_residual, certificate.cut_margin
    if residual is None or cut is None or residual > 1e-7 or cut < 1e-9:
        return
    value = arb(path.total_length) / arb(scenario.radius)
    own = Truth(end, arb(2 * TOLERANCES.miss))
    highest = own.exact["best"]
    assert highest is not None
    if value - highest > TOLERANCES.gap:
        highest = greatest(each["best"] for _, each, _ in own.members if each["best"] is not None)
    table.note("certificate", float(value - highest) / TOLERANCES.gap, line)
