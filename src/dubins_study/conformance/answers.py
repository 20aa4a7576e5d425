"""Problems of an answer, in words.

The words tell what was seen, and what to do about it. The mix-up behind a path that misses is
guessed from the path alone: by the question for which the path would be right.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import chain

import numpy as np

from dubins_study.asking.attempt import Answer
from dubins_study.conformance.interview import Interview, Seen
from dubins_study.conformance.questions import command
from dubins_study.conformance.report import Finding, Part, Status
from dubins_study.solvers.protocol import Guarantee
from dubins_study.study.arrays import FloatArray
from dubins_study.study.check.visits import visits
from dubins_study.study.judging.judge import judge, miss_reason
from dubins_study.study.kinds.leg import LEG
from dubins_study.study.kinds.table import BRANCHES_WITHOUT_PATH, kind_of, reference_of
from dubins_study.study.path import Path, drivable
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import Tolerances
from dubins_study.study.words import Claim, Order, Outcome, Verdict

_Observed = tuple[Part, Status, str, str]  # part of the answer, status, observation, advice
# claims that say that a path was found
_SUCCESS = (Claim.OPTIMAL, Claim.LOCAL, Claim.FEASIBLE)
# relative: a claimed length that differs by less is rounded
_CLAIMED = 1e-4
# radii: a path that ends within this of the target is right but for its solver's tolerance
_NEAR = 1e-2
# outcome -> observation, advice
_OUTCOMES = {
    Outcome.CRASHED: (
        "it crashed: ",
        "run the command below with your own debugger, or `dubins_study.solve(..., "
        "isolated=False)`, which asks in your own process",
    ),
    Outcome.TIMEOUT: (
        "it did not return: ",
        "look at `limit`, the second argument of solve: stop by then and return the best path so "
        "far with Claim.LIMIT",
    ),
    Outcome.OUT_OF_MEMORY: (
        "out_of_memory: ",
        "a run ends a solve that holds more than its memory limit",
    ),
    Outcome.RAISED: (
        "it raised ",
        "a solve that fails returns Solution(Claim.FAILED, message=...); it does not raise",
    ),
}
# part of the message of an exception -> advice
_RAISED = {
    "solve() takes": "write `def solve(self, question, limit)`; limit is in seconds",
    "solve() missing": "write `def solve(self, question, limit)`, with no other argument",
    "build() takes": "write `def build(self, question)`, and `def solve(self, model, limit)`",
    "build() missing": "write `def build(self, question)`, with no other argument",
}


def problems(interview: Interview, seen: Seen) -> list[Finding]:
    """The findings about one answer; empty without problems."""
    answer = seen.answer
    if answer.outcome is Outcome.RETURNED and answer.branch in BRANCHES_WITHOUT_PATH:
        observations = [*_of_point(answer)]
    elif answer.outcome is Outcome.RETURNED:
        guarantee = str(interview.declared["guarantee"])
        observations = [
            *_of_path(interview, answer),
            *_of_length(answer, guarantee),
            *_of_bound(answer),
        ]
    else:
        prefix, advice = _OUTCOMES.get(answer.outcome, (f"{answer.outcome}: ", ""))
        advice = next((text for part, text in _RAISED.items() if part in answer.message), advice)
        observations = [(Part.OUTCOME, Status.FAIL, prefix + answer.message, advice)]
    repeat = ""  # no option of `solve` hands over a guess, or the label that names a frozen problem
    if seen.question.initial_guess is None and answer.branch not in BRANCHES_WITHOUT_PATH:
        repeat = command(answer.solver, seen.question, seen.limit, interview.profile)
    return [
        Finding(
            status,
            observed=observed,
            advice=advice,
            question=seen.question.scenario.label,
            command=repeat,
            traceback=seen.observed.traceback,
            kind=kind,
        )
        for kind, status, observed, advice in observations
    ]


def _of_point(answer: Answer) -> Iterator[_Observed]:
    """Yield the problems of a primal and dual point.

    The point is the answer to a frozen convex problem, whose proof has judged it.
    """
    if answer.false_claim:
        observed = (
            f"it claims {answer.claim}, but its point is judged {answer.verdict} (primal residual "
            f"{answer.miss}, dual residual {answer.dual_residual}, gap {answer.duality_gap})"
        )
        advice = "return x, y, z and w with y and z positive where an upper end pushes"
        yield Part.CLAIM, Status.FAIL, observed, advice
    elif answer.verdict is not Verdict.OPTIMAL:
        observed = f"its point is judged {answer.verdict} (claim {answer.claim})"
        yield Part.LENGTH, Status.NOTE, observed, ""


def _of_path(interview: Interview, answer: Answer) -> Iterator[_Observed]:
    """Yield the problems of a path and its claim.

    The path is missing, does not arrive, or contradicts the claim.
    """
    path = answer.path
    claim = answer.claim
    honest = claim not in _SUCCESS
    absent = not kind_of(answer.scenario, answer.branch).exists(answer.scenario, answer.branch)
    if path is None:
        yield from _without_path(answer)
    elif claim is Claim.INFEASIBLE:
        advice = "INFEASIBLE says that no path exists; a path in the answer contradicts it"
        yield Part.CLAIM, Status.FAIL, "it claims infeasible and returns a path", advice
    # a path that misses is no problem if none exists and the solver claims no success
    elif answer.verdict is Verdict.MISSES and not (honest and absent):
        reason = miss_reason(answer.scenario, path, answer.branch, interview.tolerances)
        if honest:
            observed = f"it returns a path that misses, and says so ({claim}): {reason}"
            yield Part.CONTROLS, Status.NOTE, observed, ""
        else:
            advice = _advice(interview, answer, path)
            yield Part.CONTROLS, Status.FAIL, f"it claims {claim}, but {reason}", advice
            observed = f"it claims {claim} of a path that does not arrive"
            yield Part.CLAIM, Status.FAIL, observed, advice


def _without_path(answer: Answer) -> Iterator[_Observed]:
    """Yield the problem of an answer without a path.

    A claim of success is false. If a path exists, "infeasible" is false, and any other claim is
    worth a note.
    """
    claim = answer.claim
    if claim in _SUCCESS:
        advice = "return the path with the claim; without one, claim FAILED"
        yield Part.CLAIM, Status.FAIL, f"it claims {claim} and returns no path", advice
        return
    best = reference_of(answer.scenario, answer.branch)
    if answer.verdict is Verdict.NONE_EXISTS or best.path is None:
        return
    kind = kind_of(answer.scenario, answer.branch)
    word = kind.words_of(best.path, best.at, answer.scenario.radius) or "of length 0"
    shortest = f"there is one, {word}, of length {best.path.length:.6g}"
    if claim is Claim.INFEASIBLE:
        advice = (
            "INFEASIBLE is for a method that proves it; a local search that converges off the "
            "target claims LOCALLY_INFEASIBLE, one that finds nothing FAILED. "
            "A path exists for every target"
        )
        observed = f"it claims infeasible, that no path exists; {shortest}"
        yield Part.CLAIM, Status.FAIL, observed, advice
    else:
        reply = f"claim {claim}"
        if answer.message:
            reply += f": {answer.message}"
        yield Part.LENGTH, Status.NOTE, f"it finds no path ({reply}); {shortest}", ""


def _advice(interview: Interview, answer: Answer, path: Path) -> str:
    """Advice about a path that misses.

    Causes are tried one after another; the first that fits is the advice.
    """
    scenario = answer.scenario
    branch = answer.branch
    tolerances = interview.tolerances
    if not drivable(path):
        return (
            "claim FAILED where there is no number; a turn to the other side has the other sign of "
            "curvature, not of length"
        )
    for earlier in interview.seen:
        earlier_path = earlier.answer.path
        if earlier_path is None or earlier.answer.gap is None or not path.length > 0:
            continue
        if earlier_path == replace(path, start=earlier_path.start):
            name = earlier.question.scenario.label
            return (
                f"this is its answer to an earlier question, {name}: does it keep answers, by the "
                "target alone for instance? Start, heading, radius and the order of via points "
                "belong to the question"
            )
    if not scenario.starts(path.start):
        return "give question.scenario.start as it is, its heading to the last bit"
    if scenario.heading is None:  # what else is mixed up is judged from the path's own
        scenario = replace(scenario, heading=path.start.heading)
    if cause := visit_cause(scenario, path):
        return cause
    assert answer.miss is not None  # the path can be driven
    if answer.miss > _NEAR * scenario.radius and (cause := cause_of(scenario, path)):
        return cause
    if judge(scenario, path, tolerances=tolerances).verdict is not Verdict.MISSES:
        return (
            f"it was asked for {branch}, and its path is {answer.word}; L has the curvature "
            "1 / radius, R has -1 / radius. Leave words that the method does not tell apart out "
            "of `branches`"
        )
    excess = answer.curvature_excess or 0.0
    if excess > tolerances.curvature and (branch == "best" or excess < _FIT):
        return "keep the curvature between -1 / radius and 1 / radius: clip it where it is rounded"
    if answer.miss <= _NEAR * scenario.radius:
        return (
            "tighten the tolerance of the points and headings that a path has to meet, or claim "
            "FAILED"
        )
    if branch == "best" and kind_of(scenario) is LEG:
        X, Y = scenario.local()
        if math.hypot(X, abs(Y) - 1) < 1:
            return (
                "inside a turning disc no turn towards the target leads to it: a turn away comes "
                "first (RL or LR), or nearly a full turn (RS or LS); else claim FAILED"
            )
    return (
        "drive your path with question.scenario.start: dubins_study.Path(start, curvatures, "
        "lengths).end is where it ends"
    )


def _of_length(answer: Answer, guarantee: str) -> Iterator[_Observed]:
    """Yield the problems of a path's length.

    The path arrives but is longer, or the claimed length is not its own.
    """
    length = answer.length
    claimed = answer.claimed_length
    if answer.verdict is Verdict.LONGER and answer.claim is not Claim.INFEASIBLE:
        assert answer.gap is not None
        assert answer.path is not None
        longer = (
            f"its path, {answer.word or 'none'}, is {100 * answer.gap:.3g} % longer than the "
            f"shortest, {answer.reference_word or 'none'}{_orders(answer)}"
        )
        cause = length_cause(answer.scenario, answer.path)
        if answer.claim is Claim.OPTIMAL:
            advice = cause or "claim LOCAL unless the method proves that no path is shorter"
            yield Part.CLAIM, Status.FAIL, f"it claims optimal, but {longer}", advice
        elif guarantee in (Guarantee.EXACT, Guarantee.GLOBAL) and answer.claim in _SUCCESS:
            advice = "declare another guarantee, or claim LIMIT where the time did not suffice"
            observed = f"it declares the guarantee {guarantee!r}, but {longer}"
            yield Part.CLAIM, Status.FAIL, observed, cause or advice
        else:
            yield Part.LENGTH, Status.NOTE, longer, cause
    if claimed is None or length is None or answer.verdict is Verdict.MISSES:
        return
    if abs(claimed - length) > _CLAIMED * max(length, answer.scenario.radius):
        observed = f"claimed_length is {claimed:.6g}; its path is {length:.6g} long"
        advice = "claimed_length is a length, not a travel time, in the unit of the scenario"
        yield Part.LENGTH, Status.NOTE, observed, advice


def _orders(answer: Answer) -> str:
    """Words that compare a tour's order with the shortest's.

    Empty if the question is no tour.
    """
    best = reference_of(answer.scenario, answer.branch).path
    if answer.order is None or best is None:
        return ""
    shortest = [int(place) for place in judge(answer.scenario, best).visit_order or ()]
    if answer.order == shortest:
        return "; its order is the shortest one's"
    order = " ".join(map(str, answer.order))
    other = " ".join(map(str, shortest))
    return f"; its order is {order}, the shortest one's {other} (0 is the first of via)"


def _of_bound(answer: Answer) -> Iterator[_Observed]:
    if answer.false_bound:
        observed = (
            f"the lower bound {answer.lower_bound} lies above the shortest length, "
            f"{answer.reference}"
        )
        advice = (
            "lower_bound must hold for the question itself, not for a grid or a relaxation of it: "
            "leave it empty unless the method proves it"
        )
        yield Part.BOUND, Status.FAIL, observed, advice


def united(*findings: Iterable[Finding]) -> list[Finding]:
    """The findings, one for each reason.

    Two findings have one reason if `kind`, `status`, advice and the traceback's last frame agree.
    Without a `kind`, the observation must agree instead of the advice. The first one is kept, and
    its `count` is the sum of all counts.
    """
    groups: dict[tuple[object, ...], list[Finding]] = {}
    for finding in chain(*findings):
        reason: object = finding.observed
        if finding.kind:
            reason = finding.advice or finding.kind
        # the last line is the error, the one before it the frame; empty without a traceback
        last_frame = finding.traceback.splitlines()[-2:-1]
        groups.setdefault((finding.kind, finding.status, reason, *last_frame), []).append(finding)
    return [
        replace(group[0], count=sum(finding.count for finding in group))
        for group in groups.values()
    ]


# A path fits a guess if it ends within 0.001 radii of the target, and is at most 0.1 % too tight.
# Solvers' tolerances are far smaller, and the misses of wrong guesses far larger.
_FIT = 1e-3
_LOOSE = Tolerances(miss=_FIT, curvature=_FIT)
_POSITIONS = (
    "are these positions? A path is its controls: a curvature and a length for each arc, from "
    "which the check drives it"
)


def mix_ups(s: Scenario, path: Path) -> Iterator[tuple[str, Scenario, FloatArray, FloatArray]]:
    """Yield mix-ups: advice, question, curvatures, lengths.

    The advice is for the author. If the path with these controls arrives in this question, the
    author has made that mistake.
    """
    k = path.curvatures
    lengths = path.lengths
    yield "left and right are swapped: curvature is positive to the left", s, -k, lengths
    advice = "is your radius a curvature? A path's curvature is 1 / radius at most, not the radius"
    inverses = [1 / curvature if curvature else 0.0 for curvature in k]
    yield advice, s, np.array(inverses), lengths
    advice = (
        "is your path that of radius 1? Divide its curvatures by the radius and multiply its "
        "lengths by it"
    )
    yield advice, s, k / s.radius, lengths * s.radius
    advice = "are the lengths of your turns angles in rad? An arc is angle * radius long"
    yield advice, s, k, np.where(k != 0, lengths * s.radius, lengths)
    advice = (
        "are your controls turn rates and times? A path takes curvatures and lengths: divide by "
        "the speed, and multiply by it"
    )
    yield advice, s, k / s.speed, lengths * s.speed
    advice = (
        "your path arrives if the heading is taken for degrees: question.scenario.heading is in "
        "rad, counter-clockwise from +x"
    )
    yield advice, replace(s, heading=math.radians(s.start.heading)), k, lengths
    advice = (
        "your path arrives if it starts at (0, 0) with heading 0: is question.scenario.start used?"
    )
    yield advice, replace(s, x=0.0, y=0.0, heading=0.0), k, lengths


def cause_of(scenario: Scenario, path: Path) -> str:
    """The mix-up behind a path, as advice.

    The path misses, or is too tight. The text is empty if the mix-up is unknown.
    """
    if not path.lengths.size:
        return ""
    last = np.array([path.curvatures[-1], path.lengths[-1]])
    if (np.abs(last - scenario.points[-1]) <= 1e-6 * scenario.radius).all():
        return _POSITIONS
    with np.errstate(all="ignore"):
        for advice, other, *controls in mix_ups(scenario, path):
            fixed = Path(other.start, *controls)
            if judge(other, fixed, tolerances=_LOOSE).verdict is not Verdict.MISSES:
                return advice
    return ""


def visit_cause(scenario: Scenario, path: Path) -> str:
    """Advice about what a path leaves out.

    The path may leave out a point, the order, or a heading. The text is empty if it leaves out
    nothing, or ends away from the target. Only a closed path, and one whose order is free, gets
    advice if it ends at a via point.
    """
    end = path.end
    radius = scenario.radius
    allowed = _FIT * radius
    via = scenario.stops[: len(scenario.via)]
    if scenario.target is not None and math.dist(end[:2], scenario.target) > allowed:
        at_point = any(math.dist(end[:2], stop[:2]) <= allowed for stop in via)
        if at_point and scenario.closed:
            return (
                "it ends at its last point: a closed path drives on to its start. Leave `closed` "
                "out of `takes` if the method does not"
            )
        if at_point and scenario.order is Order.FREE:
            return (
                "it ends at a point of question.scenario.via: only they may be passed in any "
                "order, and the target stays last"
            )
        return ""
    for stop in via:
        if visits(path, [stop], radius, allowed).miss > allowed:
            return (
                f"it never passes ({stop.x:g}, {stop.y:g}), a point of question.scenario.via. "
                "Leave `via points` out of `takes` if the method has none"
            )
    if scenario.order is Order.GIVEN and visits(path, via, radius, allowed).miss > allowed:
        return (
            "it passes the via points in another order: the order of question.scenario.via is part "
            "of the question"
        )
    for stop in via:
        reached = visits(path, [stop], radius, allowed)
        if reached.turned > _FIT:
            return (
                f"it passes ({stop.x:g}, {stop.y:g}) with another heading than is given there: the "
                "third value of a point of question.scenario.via, in rad. Leave `headings at "
                "stops` out of `takes` if the method leaves it free"
            )
    if scenario.closed and _differ(end.heading, path.start.heading):
        return (
            "it ends where it starts, but not as it starts: a closed path ends with the heading "
            "with which it started"
        )
    final = scenario.final_heading
    if final is not None and _differ(end.heading, final):
        return (
            "question.scenario.final_heading is in rad, counter-clockwise from +x. Leave `final "
            "heading` out of `takes` if the method leaves it free"
        )
    return ""


def _differ(one: float, other: float) -> bool:
    """Whether two headings (rad) are far apart.

    Whole turns do not count.
    """
    return abs(math.remainder(one - other, 2 * math.pi)) > _FIT


def length_cause(scenario: Scenario, path: Path) -> str:
    """The cause of a longer path, as advice.

    The path arrives, but is longer than the shortest of its word. The text is empty if the cause is
    unknown.
    """
    turns = np.abs(path.curvatures * path.lengths)
    if (turns > 2 * math.pi + _FIT).any():
        return "an arc turns by more than a full turn: take its angle modulo 2 pi"
    tightest = np.abs(path.curvatures[path.lengths > 0]).max(initial=0.0) * scenario.radius
    if 0 < tightest < 1 - _FIT:
        return (
            f"its turns are {1 / tightest:.3g} times as wide as the radius allows: a shortest path "
            "turns with the curvature 1 / radius"
        )
    return ""
