"""Routes and legs before the check, honest and false.

The legs have a final heading; bounds are checked too.

The right verdict is known without the package's check. The place where a path passes a point is
searched on a dense sample of the path. One path that arrives is a bound for all others. The length
of one leg is that of `tests.adversary.leg_lengths`.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dubins_study.solvers.analytic import Analytic
from dubins_study.solvers.protocol import Question
from dubins_study.study.check.visits import visits
from dubins_study.study.judging.certify import certify
from dubins_study.study.judging.judge import judge
from dubins_study.study.kinds.table import reference_of
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose, Scenario, ScenarioError
from dubins_study.study.tolerances import ARRIVES, HEADED, Tolerances
from dubins_study.study.words import Claim, Verdict
from tests.adversary.leg_lengths import leg_length
from tests.adversary.routes import Rng, route_of_seed
from tests.adversary.table import Table, paste, paste_path
from tests.hard_cases import hard_poses

# a bound has to hold whenever its search ends
TOLERANCES = Tolerances(search_s=0.3)
_HIDDEN = 1e-10  # rad; an arc that lacks less of a full turn may be none by rounding


def scenario_of(seed: int, number: int) -> tuple[str, Scenario]:
    """A small route, or a leg with final heading.

    It is moved and scaled or not.
    """
    rng = np.random.default_rng((seed, number, 2))
    if number % 4:
        columns = hard_poses(6, number + seed).iloc[number % 6]
        return "final heading", Scenario(**columns)
    kind, (points, first, last) = route_of_seed(number // 4, seed)
    if rng.random() < 0.5:
        turn = rng.uniform(-math.pi, math.pi)
        radius = 10 ** rng.uniform(-3, 3)
        spin = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
        points = radius * (points @ spin + rng.uniform(-9, 9, 2))
        first, last = first + turn, None if last is None else last + turn
    else:
        radius = 1.0
    start, *via, target = points.tolist()
    return kind, Scenario(*start, first, *target, radius, via=via, final_heading=last)


class Answer(NamedTuple):
    """A path, its question, and known shortest lengths."""

    kind: str
    scenario: Scenario
    path: Path
    low: float = 0.0
    high: float = math.inf


def off_points(scenario: Scenario, path: Path) -> float:
    """Violations of a question by a path.

    In units of what is allowed: points, heading, curvature. The nearest places of a point are
    searched on a dense sample of the path; each next point after the first one that is near
    enough. After a missed point the search goes on from that point's nearest place.
    """
    radius = scenario.radius
    ends = np.concatenate([[0.0], np.cumsum(path.lengths)])
    dense = np.linspace(0.0, ends[-1], 20 * int(ends[-1] / radius) + 50)
    dense = np.union1d(dense, ends)
    sample = path.at(dense)[:, :2]
    at = 0.0
    worst = float(np.abs(path.curvatures * radius).max(initial=1.0) - 1.0) / TOLERANCES.curvature
    for x, y in scenario.via:
        away = np.hypot(*(sample - (x, y)).T)
        low = np.flatnonzero(
            (away <= np.roll(away, 1)) & (away <= np.roll(away, -1)) | (dense == 0)
        )
        low = np.union1d(low, [away.size - 1])
        left, right = dense[np.maximum(low - 1, 0)], dense[np.minimum(low + 1, away.size - 1)]
        left = np.maximum(left, at)
        keep = left <= right
        left, right = left[keep], right[keep]
        for _ in range(80):  # thirds: each neighbourhood holds one minimum
            one, other = left + (right - left) / 3, right - (right - left) / 3
            nearer = _away(path, one, x, y) <= _away(path, other, x, y)
            left, right = np.where(nearer, left, one), np.where(nearer, other, right)
        misses = _away(path, left, x, y) / (ARRIVES * radius)
        place = int(np.argmax(misses <= 1.0)) if (misses <= 1.0).any() else int(misses.argmin())
        worst = max(worst, float(misses[place]))
        at = max(at, float(left[place]))
    end = path.end
    miss = math.hypot(end.x - scenario.target_x, end.y - scenario.target_y)
    worst = max(worst, miss / (ARRIVES * radius))
    if scenario.final_heading is not None:
        turned = abs(math.remainder(end.heading - scenario.final_heading, 2 * math.pi))
        worst = max(worst, turned / HEADED)
    return worst


def _away(path: Path, at: NDArray[np.float64], x: float, y: float) -> NDArray[np.float64]:
    distance: NDArray[np.float64] = np.hypot(*(path.at(at)[:, :2] - (x, y)).T)
    return distance


def answers(
    rng: Rng, scenario: Scenario, path: Path, known: tuple[float, float]
) -> Iterator[Answer]:
    """Paths beside the best one, honest and false.

    The best path is also put before other questions.
    """
    radius = scenario.radius
    k = path.curvatures
    s = path.lengths
    off = float(rng.choice([1e-12, 1e-9, 0.5e-6, 0.99e-6, 1.01e-6, 2e-6, 1e-3]))
    angle = rng.uniform(-math.pi, math.pi)
    sign = rng.choice([-1.0, 1.0])
    yield Answer("best", scenario, path, *known)
    place = int(rng.integers(k.size + 1))
    turned = np.insert(k, place, sign / radius), np.insert(s, place, 2 * math.pi * radius)
    yield Answer("full turn", scenario, Path(scenario.start, *turned), *known)
    if k.size:
        scale = np.where(np.arange(k.size) == rng.integers(k.size), 1.0 + sign * off, 1.0)
        yield Answer("altered length", scenario, Path(scenario.start, k, s * scale), *known)
        # as long, so that its curvature is too large or its turn too small
        yield Answer("altered curvature", scenario, Path(scenario.start, k * scale, s), *known)
    longer = Path(scenario.start, [*k, 0.0], [*s, off * radius])
    yield Answer("driven on", scenario, longer, *known)
    if scenario.final_heading is not None:
        final = scenario.final_heading + sign * off
        yield Answer("wrong heading", replace(scenario, final_heading=final), path)
    via = list(scenario.via)
    first = path.length
    if via:
        first = visits(path, scenario.stops[:1], radius, 1e-6 * radius).at[0]
    if first > 0.1 * radius:  # a point on the first leg leaves the length
        x, y = path.at(first * rng.uniform(0.05, 0.95))[0, :2]
        yield Answer("point on the way", replace(scenario, via=[(x, y), *via]), path, *known)
    if not via:
        return
    place = int(rng.integers(len(via)))
    x, y = via[place]
    via[place] = x + off * radius * math.cos(angle), y + off * radius * math.sin(angle)
    yield Answer("point beside", replace(scenario, via=via), path)
    if len(via) > 1:
        yield Answer("wrong order", replace(scenario, via=scenario.via[::-1]), path)
    fewer = replace(scenario, via=scenario.via[:place] + scenario.via[place + 1 :])
    if (shortcut := Analytic().solve(Question(fewer), TOLERANCES.search_s).path) is not None:
        yield Answer("skipped point", scenario, shortcut, *known)


def own_points(rng: Rng) -> Answer:
    """Any path, with a question made from it.

    The question has points on the path, its end and, mostly, its final heading.
    """
    n = int(rng.integers(2, 7))
    rates = rng.choice([-1.0, 0.0, 1.0, rng.uniform(-1, 1)], n)
    lengths = rng.exponential(rng.choice([0.3, 1.0, 3.0]), n)
    path = Path(Pose(*rng.uniform(-3, 3, 3)), rates, lengths)
    at = np.sort(rng.uniform(0, path.length, int(rng.integers(0, 3))))
    at = at[np.diff(at, prepend=0.0, append=path.length)[:-1] > 0.05]
    x, y, heading = path.end
    final = heading if not at.size or rng.random() < 0.5 else None
    via = path.at(at)[:, :2] if at.size else []
    asked = Scenario(*path.start, x, y, via=via, final_heading=final)
    return Answer("own points", asked, path, 0.0, path.length)


def attacked(table: Table, seed: int, number: int) -> None:
    """Check `analytic` and all answers of one scenario."""
    rng = np.random.default_rng((seed, number, 3))
    table.generator, scenario = scenario_of(seed, number)
    solution = Analytic().solve(Question(scenario), TOLERANCES.search_s)
    path = solution.path
    low = solution.lower_bound
    assert path is not None
    assert low is not None
    judgement = judge(scenario, path, solution.claim, tolerances=TOLERANCES)
    certificate = certify(scenario, path, judgement, lower_bound=low, tolerances=TOLERANCES)
    allowed = [Verdict.OPTIMAL]
    if solution.claim is not Claim.OPTIMAL:
        allowed += Verdict.UNDECIDED, Verdict.LONGER
    wrong = judgement.verdict not in allowed or judgement.false_claim or certificate.false_bound
    table.note("route claim", wrong, f"solve({paste(scenario)})")
    known = (low, path.length)
    if not scenario.via:
        known = _leg(table, scenario, path.length, rng)
    try:
        cases = [*answers(rng, scenario, path, known), own_points(rng)]
    except ScenarioError:  # two points have become one
        return
    for answer in cases:
        _judged(table, answer)


def _leg(table: Table, scenario: Scenario, length: float, rng: Rng) -> tuple[float, float]:
    """Interval of a leg's length by circles and tangents.

    Its own length has to be one that the rounding of its data leaves open.
    """
    s = scenario
    radius = scenario.radius
    assert s.final_heading is not None
    leg = (s.target_x - s.x) / radius, (s.target_y - s.y) / radius, s.heading, s.final_heading
    room = 1e-13 * (1.0 + s.extent / radius)
    moved = np.vstack([np.zeros(4), rng.uniform(-room, room, (16, 4))]) + leg
    leg_lengths = [leg_length(*each, gap) for each in moved for gap in (0.0, _HIDDEN)]
    apart = min(abs(length / radius - each) / (1.0 + each) for each in leg_lengths)
    table.note(
        "leg length", apart * 1e9, f"solve({paste(s)})  # {min(leg_lengths)} {max(leg_lengths)}"
    )
    return min(leg_lengths) * radius, max(leg_lengths) * radius


def _judged(table: Table, answer: Answer) -> None:
    table.generator, scenario, path, least, most = answer
    judgement = judge(scenario, path, Claim.OPTIMAL, tolerances=TOLERANCES)
    line = f"{paste_path(scenario, 'best', path)}  # {judgement.verdict}"
    off = off_points(scenario, path)
    if abs(off - 1.0) > 1e-3:
        table.note("route arrival", (off > 1.0) != (judgement.verdict is Verdict.MISSES), line)
    if judgement.verdict is Verdict.MISSES:
        return
    interval = reference_of(scenario, tolerances=TOLERANCES).enclosure
    low = interval.low
    scale = max(interval.low, scenario.radius)
    certificate = certify(scenario, path, judgement, lower_bound=low, tolerances=TOLERANCES)
    length = path.length
    wrong = judgement.verdict is Verdict.OPTIMAL and length - most > 1.01 * TOLERANCES.gap * scale
    wrong |= judgement.verdict is Verdict.LONGER and length - least <= 0.99 * TOLERANCES.gap * scale
    wrong |= judgement.false_claim != (judgement.verdict is Verdict.LONGER)
    table.note("route verdict", wrong, line)
    # what misses its points by more than rounding may be shorter by a turn that begins there
    if off < 1e-7:
        shorter = math.inf if certificate.reference_low is None else certificate.reference_low
        table.note("route bound", (shorter - length) / scale, f"{line}, low {low!r}")
    table.note("route false bound", certificate.false_bound, f"{line}, bound {low!r}")
    bound = interval.high + 2e-9 * scale
    # of no path, whose costates are not measured
    nothing = judge(scenario, None)
    found = certify(scenario, None, nothing, lower_bound=bound, tolerances=TOLERANCES)
    table.note("route false bound", not found.false_bound, f"{line}, bound {bound!r}")
