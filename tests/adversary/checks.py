"""What is checked of one case, beside the oracle: numbers, sets, and two ways to one result."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from flint import acb, arb

from dubins_study.study.check.certificate import Certificate, Proof, certify
from dubins_study.study.check.enclosure import Enclosure, enclose
from dubins_study.study.check.verdict import Judgement, Tolerances, Verdict, judge
from dubins_study.study.closed_form.shortest import Segments, shortest, shortest_path
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario
from dubins_study.study.vehicle_frame import local
from dubins_study.study.words import BRANCHES
from tests.adversary.oracle import Truth, drive, greatest, least, side
from tests.adversary.table import Table, paste, paste_path

_TURN = {"L": 1, "S": 0, "R": -1}
_EPS = math.ulp(1.0)
_CLOSE = 1 + 1e-9  # what two computations of one tolerance may differ by
_SPREAD = 4  # how much wider than the sampled truth the whole truth may be
_SURE = 2.0  # a set so many times as wide meets no edge: then nothing is open
TOLERANCES = Tolerances()


def ulp(length: float, radius: float) -> float:
    """An ulp of max(length, radius): the unit of every difference of lengths."""
    return math.ulp(max(length, radius))


def outside(value: arb, hulls: Sequence[tuple[arb, arb]]) -> arb:
    """How far a number lies from the nearest of some intervals; infinite if there are none."""
    apart = [greatest((low - value, value - high, arb(0))) for low, high in hulls]
    return least(apart) if apart else arb("inf")


def closed_form(table: Table, scenario: Scenario, truth: Truth, rng: np.random.Generator) -> None:
    """The scalar closed form of every branch: length, end and existence."""
    # products of eps and a coordinate below 1e-292 have lost digits
    tiny = arb(1e-290) / arb(scenario.radius)
    off = abs(arb(local(scenario).delta) - truth.delta) / greatest((truth.delta, tiny))
    table.note("delta", float(off) / _EPS, f"local({paste(scenario)}).delta")
    for branch in BRANCHES:
        optimum, line = shortest(scenario, branch), paste(scenario, branch)
        if optimum is None:
            wrong = truth.exact[branch] is not None
            if wrong and truth.touches(branch):
                wrong = not truth.absent(branch)
            table.note("closed form existence", wrong, f"shortest({line})  # has a path")
            continue
        table.note("closed form existence", False, line)
        path = shortest_path(scenario, branch)
        assert path is not None
        end = _end(optimum.word, optimum.segments)
        length = path.total_length
        far = _deviation(truth, branch, scenario, length, end, rng)
        table.note("closed form length", far, f"shortest_path({line}).total_length")
        # the set's own width, and the rounding of both segments
        room = truth.delta + 16 * _EPS * (1 + arb(optimum.total))
        off = end - truth.target
        apart = greatest((abs(off.real), abs(off.imag))) / room
        table.note("closed form end", float(apart), f"shortest_path({line}).end")


def _end(word: str, segments: Segments) -> acb:
    driven = [arb(s) for s in segments if s > 0]
    return drive([(arb(_TURN[c]), s) for c, s in zip(word, driven, strict=True)])[0]


def _deviation(
    truth: Truth,
    branch: str,
    scenario: Scenario,
    length: float,
    end: acb,
    rng: np.random.Generator,
) -> float:
    """By how many ulp a length leaves the truth; looks closer until the set explains it."""
    radius = arb(scenario.radius)
    unit = arb(ulp(length, scenario.radius)) / radius
    value = arb(length) / radius
    exact = truth.exact[branch]
    far = [arb("inf") if exact is None else abs(value - exact)]
    if not far[0] <= 4 * unit and truth.has(end):
        own = truth.member(end).lengths[branch]
        far += [] if own is None else [abs(value - own)]
    for refined in (False, True):
        if not least(far) <= 4 * unit:
            if refined:
                truth.refine(rng)
            far.append(outside(value, truth.hulls(branch)))
    return float(least(far) / unit)


def enclosures(table: Table, scenario: Scenario, truth: Truth) -> None:
    """Every interval holds the truth of every sampled target, and little else."""
    radius = arb(scenario.radius)
    for branch in BRANCHES:
        found = enclose(scenario, branch)
        line = f"enclose({paste(scenario, branch)})"
        lengths = (member.lengths[branch] for member in truth.members)
        values = [length * radius for length in lengths if length is not None]
        worst, value = _worst_outside(values, [(found.low, found.high)], scenario.radius)
        table.note("enclosure holds truth", worst, f"{line}  # {value!r}")
        worst, value = _worst_outside(values, found.parts, scenario.radius)
        table.note("parts hold truth", worst, f"{line}.parts  # {value!r}")
        table.note("absent", _absent_wrong(truth, branch, found), f"{line}.absent")
        undecided = bool(values) and not math.isfinite(found.high)
        table.note("enclosure decided", undecided, line)
        if values and not undecided and not truth.touches(branch, _SURE):
            spread = float(greatest(values) - least(values)) + 4 * ulp(found.high, scenario.radius)
            table.note("enclosure width", (found.high - found.low) / spread, line)


def _worst_outside(
    values: Sequence[arb], intervals: Sequence[tuple[float, float]], radius: float
) -> tuple[float, float]:
    """By how many ulp the worst of some numbers lies outside of all intervals; that number."""
    hulls = [(arb(low), arb(high)) for low, high in intervals]
    worst, at = 0.0, math.nan
    for value in values:
        if any(low <= value <= high for low, high in hulls):
            continue
        off = float(outside(value, hulls)) / ulp(float(value), radius)
        if off > worst:
            worst, at = off, float(value)
    return worst, at


def _absent_wrong(truth: Truth, branch: str, found: Enclosure) -> bool:
    """Whether `absent` denies a target without a path, or claims one where all have a path."""
    if truth.touches(branch):
        return truth.absent(branch) and not found.absent
    if truth.touches(branch, _SURE):
        return False
    return bool(found.absent) != (truth.exact[branch] is None)


def bounds(table: Table, scenario: Scenario, truth: Truth) -> None:
    """A bound below the truth is not called false; one above the whole truth is."""
    branch = "best"
    path = shortest_path(scenario, branch)
    judged = judge(scenario, path, branch=branch)
    values = [each["best"] for _, each, _ in truth.members if each["best"] is not None]
    low, high = (float(end) * scenario.radius for end in (least(values), greatest(values)))
    scale = max(high, scenario.radius)
    tried = [(high - 1e-12 * scale, False)]
    if not truth.touches(branch, _SURE):
        tried.append((high + 4 * (high - low) + 1e-5 * scale, True))
    for bound, is_false in tried:
        certificate = certify(scenario, path, judged, branch, lower_bound=bound)
        table.note(
            "bounds",
            certificate.false_bound != is_false,
            f"solve({paste(scenario, branch)})  # bound {bound!r}",
        )


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
        if length.wrong:
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
