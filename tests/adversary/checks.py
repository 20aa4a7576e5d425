"""Checks of one case against the oracle.

The oracle itself is checked against other ways to its numbers.
"""

import math
from collections.abc import Sequence

import numpy as np
from flint import acb, arb

from dubins_study.study.body_coordinates import local
from dubins_study.study.check.enclosure import Enclosure, enclose
from dubins_study.study.closed_form.shortest import shortest, shortest_path
from dubins_study.study.judging.certify import certify
from dubins_study.study.judging.judge import judge
from dubins_study.study.path import drivable
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import Tolerances
from dubins_study.study.words import BRANCHES, TURN, Proof, Verdict
from tests.adversary.generators import Answer
from tests.adversary.oracle import DIGITS, WORDS, drive, end_of, greatest, least, lengths, side
from tests.adversary.table import Table, paste, paste_path
from tests.adversary.truth import Truth
from tests.brute_force import words_by_search

TOLERANCES = Tolerances()
_EPS = math.ulp(1.0)
_SURE = 2.0  # a set so many times as wide meets no edge: then nothing is open
_STEPS = 6  # first pieces that are tried in front of the oracle's shortest
_CLEAR = 0.02  # radii from every edge, next to which a scan does not tell two roots apart
_CLOSE = 1 + 1e-9  # what two computations of one tolerance may differ by
_SPREAD = 8  # how much wider than the sampled truth the whole truth may be


def ulp(length: float, radius: float) -> float:
    """The unit of every difference of lengths.

    It is 2^-52 of max(length, radius): one ulp or two.
    """
    return max(math.ulp(0.0), _EPS * max(length, radius))


def outside(value: arb, hulls: Sequence[tuple[arb, arb]]) -> arb:
    """Distance of a number from the nearest interval.

    Infinite if there are no intervals.
    """
    apart = [greatest((low - value, value - high, arb(0))) for low, high in hulls]
    return least(apart) if apart else arb("inf")


def closed_form(table: Table, scenario: Scenario, truth: Truth, rng: np.random.Generator) -> None:
    """Check the scalar closed form of every branch.

    Checked are its length, its end, and whether it has a path.
    """
    # products of eps and a coordinate below 1e-292 have lost digits, and so has a tiny delta
    tiny = greatest((arb(1e-290) / arb(scenario.radius), arb(1e-300)))
    off = abs(arb(local(scenario).delta) - truth.delta) / greatest((truth.delta, tiny))
    table.note("delta", float(off) / _EPS, f"local({paste(scenario)}).delta")
    for branch in BRANCHES:
        optimum = shortest(scenario, branch)
        line = paste(scenario, branch)
        path = shortest_path(scenario, branch)
        if optimum is None or path is None:
            wrong = truth.exact[branch] is not None
            if wrong and truth.touches(branch):
                wrong = not truth.absent(branch)
            table.note("closed form existence", wrong, f"shortest({line})  # has a path")
            continue
        table.note("closed form existence", False, line)
        driven = [arb(s) for s in optimum.segments if s > 0]
        word = zip(optimum.word, driven, strict=True)
        end = drive([(arb(TURN[letter]), s) for letter, s in word])[0]
        far = _deviation(truth, branch, scenario, path.length, end, rng)
        table.note("closed form length", far, f"shortest_path({line}).length")
        # the set's own width, and the rounding of both segments
        room = truth.delta + 16 * _EPS * (1 + arb(optimum.total))
        missed = end - truth.target
        apart = greatest((abs(missed.real), abs(missed.imag))) / room
        table.note("closed form end", float(apart), f"shortest_path({line}).end")


def _deviation(
    truth: Truth,
    branch: str,
    scenario: Scenario,
    length: float,
    end: acb,
    rng: np.random.Generator,
) -> float:
    """Difference of a length from the truth, in ulp.

    The truth is refined until its set explains the length.
    """
    radius = arb(scenario.radius)
    unit = arb(ulp(length, scenario.radius)) / radius
    value = arb(length) / radius
    exact = truth.exact[branch]
    far = arb("inf") if exact is None else abs(value - exact)
    if not far <= 4 * unit and truth.has(end):
        exact_length = truth.member(end).lengths[branch]
        far = far if exact_length is None else least((far, abs(value - exact_length)))
    for refined in (False, True):
        if not far <= 4 * unit:
            if refined:
                truth.refine(rng)
            far = least((far, outside(value, truth.hulls(branch))))
    return float(far / unit)


def enclosures(table: Table, scenario: Scenario, truth: Truth) -> dict[str, tuple[float, float]]:
    """Check every interval against all sampled targets.

    An interval has to hold the truth of each, and little else. Returns the least and the greatest
    of the sampled lengths by branch, rounded inwards.
    """
    R = scenario.radius
    sampled = {}
    for branch in BRANCHES:
        enclosure = enclose(scenario, branch)
        line = f"enclose({paste(scenario, branch)})"
        known = (member.lengths[branch] for member in truth.members)
        values = [length * arb(R) for length in known if length is not None]
        parts = [(arb(low), arb(high)) for low, high in enclosure.parts]
        beyond = [v for v in values if not any(low <= v <= high for low, high in parts)]
        off = {float(v): float(outside(v, parts)) / ulp(float(v), R) for v in beyond}
        worst = max(off, key=off.__getitem__, default=0.0)
        table.note("parts hold truth", off.get(worst, 0.0), f"{line}.parts  # {worst!r}")
        table.note("absent", _absent_wrong(truth, branch, enclosure), f"{line}.absent")
        undecided = bool(values) and not math.isfinite(enclosure.high)
        table.note("enclosure decided", undecided, line)
        if not values:
            continue
        low, high = least(values), greatest(values)
        if not undecided and not truth.touches(branch, _SURE):
            spread = float(high - low) + 4 * ulp(enclosure.high, R)
            table.note("enclosure width", (enclosure.high - enclosure.low) / spread, line)
        sampled[branch] = math.nextafter(float(low), math.inf), math.nextafter(float(high), 0.0)
    return sampled


def _absent_wrong(truth: Truth, branch: str, enclosure: Enclosure) -> bool:
    """Whether `absent` contradicts the truth.

    It is wrong if it denies a target without a path, or claims one where all have a path.
    """
    if truth.touches(branch):
        return truth.absent(branch) and not enclosure.absent
    if truth.touches(branch, _SURE):
        return False
    return bool(enclosure.absent) != (truth.exact[branch] is None)


def bounds(table: Table, scenario: Scenario, truth: Truth) -> None:
    """Check that only false bounds are called false.

    A bound below the truth is not called false. One above the whole truth is.
    """
    path = shortest_path(scenario)
    judgement = judge(scenario, path)
    values = [each["best"] for _, each, _ in truth.members if each["best"] is not None]
    low, high = (float(end) * scenario.radius for end in (least(values), greatest(values)))
    scale = max(high, scenario.radius)
    cases = {high - 1e-12 * scale: False}
    if not truth.touches("best", _SURE):
        cases[high + 4 * (high - low) + 1e-5 * scale] = True
    for bound, is_false in cases.items():
        wrong = certify(scenario, path, judgement, lower_bound=bound).false_bound != is_false
        table.note("bounds", wrong, f"solve({paste(scenario)})  # bound {bound!r}")


def answer(table: Table, asked: Answer, truth: Truth, rng: np.random.Generator) -> None:
    """Check the verdict, proof and certificate of an answer.

    Its end and its length are computed in 60 digits.
    """
    scenario, branch, path = asked
    judgement = judge(scenario, path, branch=branch)
    certificate = certify(scenario, path, judgement, branch)
    line = f"{paste_path(scenario, branch, path)}  # {judgement.verdict}, {certificate.proof}"
    residual = certificate.pmp_residual
    cut = certificate.cut_margin
    if not drivable(path):
        wrong = (judgement.verdict, residual, cut) != (Verdict.MISSES, None, None)
        table.note("broken path", wrong, line)
        return
    end = end_of(scenario, path)
    length = arb(path.length) / arb(scenario.radius)
    arrives = _arrives(asked, truth, end)
    optimal = judgement.verdict is Verdict.OPTIMAL
    accepted = optimal or judgement.verdict is Verdict.LONGER
    if arrives is not None:
        table.note("arrival", accepted != arrives, line)
    below, right, wrong = _compared(truth, branch, length)
    if wrong and optimal:
        truth.refine(rng)
        below, right, wrong = _compared(truth, branch, length)
    if accepted and below:
        is_wrong = wrong if optimal else right
        table.note("verdict", is_wrong, line)
    is_proved = certificate.proof is Proof.PROVED
    table.note("proved", is_proved and (arrives is False or wrong), line)
    if residual is not None and cut is not None and residual <= 1e-7 and cut >= 1e-9:
        # summed exactly: a path of 1e12 radii has a double for its length that is off by 1e-4
        summed = sum(map(arb, path.lengths.tolist()), arb(0)) / arb(scenario.radius)
        table.note("certificate", _above_shortest(end, summed), line)


def _arrives(asked: Answer, truth: Truth, end: acb) -> bool | None:
    """Whether a path is admissible and meets the target.

    None where rounding leaves that open.
    """
    scenario, branch, path = asked
    R = scenario.radius
    if truth.exact[branch] is None:
        return None  # an admissible path of other pieces may arrive where the word itself does not
    controls = zip(path.curvatures.tolist(), path.lengths.tolist(), strict=True)
    bend = excess([k * R for k, s in controls if s > 0], branch)
    miss = float(abs(end - truth.target))
    rounding = 32 * _EPS * (scenario.extent + path.length) / R
    if abs(bend - TOLERANCES.curvature) < 1e-14:
        return None
    if miss > TOLERANCES.miss * _CLOSE + 2 * rounding:
        return False
    if miss >= TOLERANCES.miss / _CLOSE or rounding > 0.5:
        return None
    return bend <= TOLERANCES.curvature


def excess(rates: Sequence[float], branch: str) -> float:
    """Largest violation of a branch's limits by some rates.

    A rate is curvature times radius.
    """
    if branch == "best":
        return max((abs(u) - 1 for u in rates), default=0.0)
    first = 1 if branch[0] == "L" else -1
    if branch[1] == "S":
        return max((max(-u * first, u * first - 1) for u in rates), default=0.0)
    return min(
        max((abs(u - (first if i < n else -first)) for i, u in enumerate(rates)), default=0.0)
        for n in range(len(rates) + 1)
    )


def _compared(truth: Truth, branch: str, length: arb) -> tuple[bool, bool, bool]:
    """Compare a length with the sampled truth.

    Returns whether some truth is below the length, whether the length is surely right, and whether
    it is surely wrong. The whole truth is hardly wider than the sampled truth.
    """
    hulls = truth.hulls(branch)
    below = [length if side(high - length) >= 0 else high for low, high in hulls if low <= length]
    reference = greatest(below) if below else length
    allowed = TOLERANCES.gap * float(greatest((reference, arb(1))))
    # a length that is hardly below some of the truth is as right as one that is hardly above
    excess_length = float(length - reference) if below else math.inf
    apart = min(excess_length, float(outside(length, hulls)))
    room = _SPREAD * max((float(high - low) for low, high in hulls), default=0.0)
    return bool(below), apart <= allowed / _CLOSE, apart > allowed * _CLOSE + room


def _above_shortest(end: acb, length: arb) -> float:
    """Excess over the shortest path to the same end.

    In units of the allowed gap. The neighbourhood of the end is as wide as the check lets a path
    miss.
    """
    neighbourhood = Truth(end, arb(2 * TOLERANCES.miss))
    highest = neighbourhood.exact["best"]
    assert highest is not None
    if length - highest > TOLERANCES.gap:
        highest = greatest(
            each["best"] for _, each, _ in neighbourhood.members if each["best"] is not None
        )
    return float(length - highest) / TOLERANCES.gap


def oracle(table: Table, scenario: Scenario, truth: Truth, rng: np.random.Generator) -> None:
    """The oracle against other ways to the same number."""
    line = f"Truth.of({paste(scenario)})"
    table.note("oracle by steps", _steps(truth, rng), line)
    wide = Truth(truth.target, arb(_CLEAR))
    if not any(wide.touches(word) for word in WORDS):
        table.note("oracle by scan", _scan(truth), line)


def _steps(truth: Truth, rng: np.random.Generator) -> bool:
    """Whether a first piece beats the oracle's shortest.

    The rest of the path is the shortest one from the end of that piece.
    """
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
    """Worst difference from a search over the first arc.

    The search is done in doubles. The unit is 1e-9 of max(length, 1).
    """
    searched = words_by_search(float(truth.target.real), float(truth.target.imag))
    worst = 0.0
    for word in WORDS:
        exact = truth.exact[word]
        length = searched[word]
        if exact is None:
            if not math.isinf(length):
                worst = math.inf
        else:
            worst = max(worst, abs(float(exact) - length) / max(1.0, float(exact)) * 1e9)
    return worst
