"""One case checked beside the oracle, and the oracle beside other ways to its numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence

import mpmath
import numpy as np
from flint import acb, arb

from dubins_study.study.body_coordinates import local
from dubins_study.study.check.certificate import certify
from dubins_study.study.check.enclosure import Enclosure, enclose
from dubins_study.study.check.verdict import judge
from dubins_study.study.closed_form.shortest import Segments, shortest, shortest_path
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import BRANCHES
from tests.adversary.oracle import DIGITS, WORDS, drive, greatest, least, lengths
from tests.adversary.table import Table, paste
from tests.adversary.truth import Truth
from tests.brute_force import words_by_search

_TURN = {"L": 1, "S": 0, "R": -1}
_EPS = math.ulp(1.0)
_SURE = 2.0  # a set so many times as wide meets no edge: then nothing is open
_STEPS = 6  # first pieces that are tried in front of the oracle's shortest
_CLEAR = 0.02  # radii from every edge, next to which a scan does not tell two roots apart


def ulp(length: float, radius: float) -> float:
    """2^-52 of max(length, radius), one ulp or two: the unit of every difference of lengths."""
    return max(math.ulp(0.0), _EPS * max(length, radius))


def outside(value: arb, hulls: Sequence[tuple[arb, arb]]) -> arb:
    """How far a number lies from the nearest of some intervals; infinite if there are none."""
    apart = [greatest((low - value, value - high, arb(0))) for low, high in hulls]
    return least(apart) if apart else arb("inf")


def closed_form(table: Table, scenario: Scenario, truth: Truth, rng: np.random.Generator) -> None:
    """The scalar closed form of every branch: length, end and existence."""
    # products of eps and a coordinate below 1e-292 have lost digits, and so has a tiny delta
    tiny = greatest((arb(1e-290) / arb(scenario.radius), arb(1e-300)))
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
        missed = end - truth.target
        apart = greatest((abs(missed.real), abs(missed.imag))) / room
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


def enclosures(table: Table, scenario: Scenario, truth: Truth) -> dict[str, tuple[float, float]]:
    """Every interval holds the truth of every sampled target, and little else.

    Returns the least and the greatest of the sampled lengths by branch, rounded inwards.
    """
    radius = arb(scenario.radius)
    sampled = {}
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
        if values:
            low, high = float(least(values)), float(greatest(values))
            sampled[branch] = math.nextafter(low, math.inf), math.nextafter(high, 0.0)
    return sampled


def dense(table: Table, scenario: Scenario, truth: Truth, rng: np.random.Generator) -> None:
    """The same of some hundred targets more, on a share of the cases."""
    truth.refine(rng)
    radius = arb(scenario.radius)
    for branch in BRANCHES:
        found = enclose(scenario, branch)
        lengths = (member.lengths[branch] for member in truth.members)
        values = [length * radius for length in lengths if length is not None]
        worst, value = _worst_outside(values, found.parts, scenario.radius)
        line = f"enclose({paste(scenario, branch)}).parts  # {value!r}"
        table.note("parts hold many", worst, line)
        table.note("absent", truth.absent(branch) and not found.absent, line)


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


def oracle(table: Table, scenario: Scenario, truth: Truth, rng: np.random.Generator) -> None:
    """The oracle against other ways to the same number."""
    line = f"Truth.of({paste(scenario)})"
    table.note("oracle by mpmath", _sine(scenario.heading), line)
    table.note("oracle by steps", _steps(truth, rng), line)
    wide = Truth(truth.target, arb(_CLEAR))
    if not any(wide.touches(word) for word in WORDS):
        table.note("oracle by scan", _scan(truth), line)


def _sine(heading: float) -> float:
    """Error of sine and cosine of the heading beside mpmath's, in 1e-60."""
    sin, cos = arb(heading).sin_cos()
    with mpmath.workdps(DIGITS + 20):
        pairs = ((sin, mpmath.sin(heading)), (cos, mpmath.cos(heading)))
        return max(
            float(abs(ball - arb(mpmath.nstr(number, DIGITS + 20)))) * 1e60
            for ball, number in pairs
        )


def _steps(truth: Truth, rng: np.random.Generator) -> bool:
    """Whether some first piece and the shortest way from its end beat the oracle's shortest."""
    best = truth.exact["best"]
    assert best is not None, "some path to every target exists"
    for turn in (-1, 0, 1):
        for step in (10 ** rng.uniform(-6, 0.8, _STEPS // 3)).tolist():
            z, direction = drive([(arb(turn), arb(step))])
            rest = lengths((truth.target - z) / direction)["best"]
            assert rest is not None
            if rest + step < best - arb(10.0) ** (10 - DIGITS) * (1 + best):
                return True
    return False


def _scan(truth: Truth) -> float:
    """Worst difference (in 1e-9 of max(length, 1)) from a search over the first arc in doubles."""
    searched = words_by_search(float(truth.target.real), float(truth.target.imag))
    worst = 0.0
    for word in WORDS:
        exact, found = truth.exact[word], searched[word]
        if exact is None:
            worst = max(worst, 0.0 if math.isinf(found) else math.inf)
        else:
            worst = max(worst, abs(float(exact) - found) / max(1.0, float(exact)) * 1e9)
    return worst
