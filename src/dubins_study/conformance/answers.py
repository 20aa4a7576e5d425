"""What is wrong with an answer, in words: what was seen, and what to do about it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from enum import StrEnum
from typing import NamedTuple

from dubins_study.conformance.causes import cause_of
from dubins_study.conformance.faults import (
    claimed_length_cause,
    length_cause,
    start_cause,
    tightness_cause,
)
from dubins_study.conformance.findings import Finding, Status
from dubins_study.conformance.interview import Seen
from dubins_study.conformance.questions import check_command, command, name_of
from dubins_study.solvers.attempt import Answer
from dubins_study.solvers.protocol import Guarantee
from dubins_study.study.check.verdict import curvature_excess, judge
from dubins_study.study.path import Path, drivable
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim, Outcome, Verdict


class Kind(StrEnum):
    """Which part of an answer a finding is about."""

    OUTCOME = "outcome"
    CONTROLS = "controls"
    CLAIM = "claim"
    BOUND = "bound"
    LENGTH = "length"


class Problem(NamedTuple):
    """A finding and the part of the answer that it is about."""

    kind: Kind
    finding: Finding


# claims that say that a path was found
_SUCCESS = (Claim.OPTIMAL, Claim.LOCAL, Claim.FEASIBLE)
# relative: a claimed length that differs by less is rounded
_CLAIMED = 1e-4
# radii: a path that ends within this of the target is right but for its solver's tolerance
_NEAR = 1e-2


def problems(seen: Seen, name: str, guarantee: str) -> list[Problem]:
    """What is wrong with one answer; empty if nothing is.

    Args:
        seen: the judged answer.
        name: of its scenario.
        guarantee: the solver's, as it declares it.
    """
    answer = seen.answer
    spec = answer.solver

    def problem(
        kind: Kind, status: Status, observed: str, advice: str = "", traceback: str = ""
    ) -> Problem:
        shown = command(spec, seen.question)
        if seen.question.initial_guess is not None:  # no option of `solve` hands one over
            shown = check_command(spec, "warm")
        return Problem(kind, Finding(status, observed, advice, name, shown, traceback))

    if answer.outcome is not Outcome.RETURNED:
        observed, advice = _not_returned(answer, seen)
        return [problem(Kind.OUTCOME, Status.FAIL, observed, advice, seen.traceback)]
    listed = []
    for kind, status, observed, advice in _of_path(answer) + _of_length(answer, guarantee):
        listed.append(problem(kind, status, observed, advice))
    if answer.false_bound:
        bound = "" if answer.lower_bound is None else f" {answer.lower_bound:.10g}"
        shortest = "" if answer.reference is None else f", {answer.reference:.10g}"
        observed = f"the lower bound{bound} lies above the shortest length{shortest}"
        advice = (
            "lower_bound must hold for the question itself, not for a grid or a relaxation of it: "
            "leave it empty unless the method proves it"
        )
        listed.append(problem(Kind.BOUND, Status.FAIL, observed, advice))
    return listed


_Observed = tuple[Kind, Status, str, str]
_OUTCOMES = {
    Outcome.CRASHED: "run the command below with your own debugger, or `dubins_study.solve(..., "
    "isolated=False)`, which asks in your own process",
    Outcome.TIMEOUT: "look at `limit`, the second argument of solve: stop by then and return the "
    "best path so far with Claim.LIMIT",
    Outcome.OUT_OF_MEMORY: "a run ends a solve that holds more than its memory limit",
    Outcome.RAISED: "a solve that fails returns Solution(Claim.FAILED, message=...); it does not "
    "raise",
}
_RAISED = {
    "solve() takes": "write `def solve(self, question, limit)`; limit is in seconds",
    "solve() missing": "write `def solve(self, question, limit)`, with no other argument",
    "build() takes": "write `def build(self, question)`, and `def solve(self, model, limit)`",
    "build() missing": "write `def build(self, question)`, with no other argument",
    "expected a Solution": "solve returns a Solution: return Solution(Claim.LOCAL, path)",
    "expected one of: optimal": "a claim is one of dubins_study.Claim",
    "curvature has shape": "give one curvature and one length for each arc",
    "expected a Path or None": "make a Path(question.scenario.start, curvatures, lengths)",
}


def _not_returned(answer: Answer, seen: Seen) -> tuple[str, str]:
    observed = {
        Outcome.RAISED: f"it raised {answer.message}",
        Outcome.TIMEOUT: f"it did not return: {answer.message}",
        Outcome.CRASHED: f"it crashed: {answer.message}",
    }.get(answer.outcome, f"{answer.outcome}: {answer.message}")
    for part, advice in _RAISED.items():
        if part in answer.message:
            return observed, advice
    return observed, _OUTCOMES.get(answer.outcome, "")


def _of_path(answer: Answer) -> list[_Observed]:
    """What keeps an answer from arriving, or from being what it says."""
    path, claim = answer.path, answer.claim
    honest = claim not in _SUCCESS
    status = Status.NOTE if honest else Status.FAIL
    if path is None:
        return _without_path(answer)
    if claim is Claim.INFEASIBLE:
        advice = "INFEASIBLE says that no path exists; a path in the answer contradicts it"
        return [(Kind.CLAIM, Status.FAIL, "it claims infeasible and returns a path", advice)]
    if answer.verdict is not Verdict.MISSES or (honest and answer.reference is None):
        return []
    observed, advice = _missing(answer, path)
    if honest:
        observed, advice = f"it returns a path that misses, and says so ({claim}): {observed}", ""
    else:
        observed = f"it claims {claim}, but {observed}"
    return [(Kind.CONTROLS, status, observed, advice)]


def _without_path(answer: Answer) -> list[_Observed]:
    claim, exists = answer.claim, answer.reference is not None
    if claim in _SUCCESS:
        advice = "return the path with the claim; without one, claim FAILED"
        return [(Kind.CLAIM, Status.FAIL, f"it claims {claim} and returns no path", advice)]
    if answer.verdict is Verdict.NONE_EXISTS or not exists:
        return []
    there = (
        f"there is one, {answer.reference_word or 'of length 0'}, of length {answer.reference:.6g}"
    )
    if claim is Claim.INFEASIBLE:
        observed = f"it claims infeasible, that no path exists; {there}"
        advice = (
            "a search that finds nothing claims FAILED; INFEASIBLE is for a method that proves it. "
            "A path exists for every target"
        )
        return [(Kind.CLAIM, Status.FAIL, observed, advice)]
    said = f": {answer.message}" if answer.message else ""
    observed = f"it finds no path (claim {claim}{said}); {there}"
    return [(Kind.LENGTH, Status.NOTE, observed, "")]


def _missing(answer: Answer, path: Path) -> tuple[str, str]:
    """Which condition a path fails, and why it may."""
    scenario, branch = answer.scenario, answer.branch
    if not drivable(path):
        if path.length.min(initial=0.0) < 0:
            advice = "a turn to the other side has the other sign of curvature, not of length"
            observed = f"a length is {path.length.min():.3g}; lengths are not negative"
            return observed, cause_of(scenario, path) or advice
        return "a curvature or a length is not finite", "claim FAILED where there is no number"
    radii = [k * scenario.radius for k, s in zip(path.curvature, path.length, strict=True) if s > 0]
    excess = curvature_excess(radii, "best")
    end = path.end
    miss = math.hypot(end.x - scenario.target_x, end.y - scenario.target_y) / scenario.radius
    if path.start != scenario.start:
        advice = start_cause(scenario, path)
        digits = 6 if _pose(path.start) != _pose(scenario.start) else 17
        given, expected = _pose(path.start, digits), _pose(scenario.start, digits)
        return f"its path starts at {given}, not at {expected}", advice
    if excess > 1e-9:
        observed = (
            f"its curvature is {1 + excess:.3g} times the allowed one, "
            f"1 / radius = {1 / scenario.radius:.4g}"
        )
        arrives = miss < _NEAR
        return observed, (
            tightness_cause(scenario, excess) if arrives else cause_of(scenario, path)
        ) or tightness_cause(scenario, excess)
    if miss > 1e-6:
        observed = f"its path ends {miss:.3g} radii from the target; 1e-6 counts as arriving"
        if miss < _NEAR:
            return observed, "tighten the tolerance of the end point, or claim FAILED"
        return observed, cause_of(scenario, path) or _in_disc(scenario, branch) or (
            "drive your path with question.scenario.start: dubins_study.Path(start, curvatures, "
            "lengths).end is where it ends"
        )
    if branch != "best" and judge(scenario, path).verdict is not Verdict.MISSES:
        if answer.word == branch:
            return (
                f"its turns are wider than the radius; those of a path {branch} are not",
                "is question.scenario.radius used? Both turns have a curvature of 1 / radius",
            )
        return (
            f"it was asked for {branch}, and its path is {answer.word}",
            "question.branch is the word that is asked for; leave words that the method does not "
            "tell apart out of `branches`",
        )
    return "its path is too long to be driven to within a radius", ""


def _in_disc(scenario: Scenario, branch: str) -> str:
    """What to do about targets inside a turning disc, if the scenario's is one; else nothing."""
    X, Y = scenario.local()
    if branch != "best" or math.hypot(X, abs(Y) - 1) >= 1:
        return ""
    return (
        "inside a turning disc no turn towards the target leads to it: a turn away comes first (RL "
        "or LR), or nearly a full turn (RS or LS). Claim FAILED where the method has neither"
    )


def _pose(pose: Iterable[float], digits: int = 6) -> str:
    return "({})".format(", ".join(f"{value:.{digits}g}" for value in pose))


def _of_length(answer: Answer, guarantee: str) -> list[_Observed]:
    """A path that arrives but is longer, and a claimed length that is not its own."""
    listed: list[_Observed] = []
    length, claimed = answer.length, answer.claimed_length
    if answer.verdict is Verdict.LONGER and answer.claim is not Claim.INFEASIBLE:
        listed.append(_longer(answer, guarantee))
    if claimed is not None and length is not None and answer.verdict is not Verdict.MISSES:
        scale = max(length, answer.scenario.radius)
        if abs(claimed - length) > _CLAIMED * scale:
            observed = f"claimed_length is {claimed:.6g}; its path is {length:.6g} long"
            assert answer.path is not None  # it has a length
            advice = claimed_length_cause(answer.scenario, answer.path, claimed)
            listed.append((Kind.LENGTH, Status.NOTE, observed, advice))
    return listed


def _longer(answer: Answer, guarantee: str) -> _Observed:
    assert answer.gap is not None
    word, best = answer.word or "none", answer.reference_word or "none"
    share = 100 * answer.gap
    how = f"{share:.3g} % longer than the shortest one ({word} instead of {best})"
    if word == best:
        how = f"{share:.3g} % longer than the shortest {best}"
    cause = "" if answer.path is None else length_cause(answer.scenario, answer.path)
    if answer.claim is Claim.OPTIMAL:
        advice = cause or "claim LOCAL unless the method proves that no path is shorter"
        observed = f"it claims optimal, but its path is {how}"
        return Kind.CLAIM, Status.FAIL, observed, advice
    exact = guarantee in (Guarantee.EXACT, Guarantee.GLOBAL)
    if exact and answer.claim in _SUCCESS:
        advice = cause or "declare another guarantee, or claim LIMIT where the time did not suffice"
        observed = f"it declares the guarantee {guarantee!r}, but its path is {how}"
        return Kind.CLAIM, Status.FAIL, observed, advice
    return Kind.LENGTH, Status.NOTE, f"its path is {how}", cause


def unanswered(asked: Iterable[Seen], name: str) -> tuple[Finding, ...]:
    """Findings about questions that were not answered; of scenarios with the name, or their own."""
    listed = [
        p for seen in asked for p in problems(seen, name or name_of(seen.question.scenario), "")
    ]
    return united(problem for problem in listed if problem.kind is Kind.OUTCOME)


def united(found: Iterable[Problem]) -> tuple[Finding, ...]:
    """The findings, one for each reason: of those that are the same, the first and their count."""
    groups: dict[tuple[object, ...], list[Finding]] = {}
    for kind, finding in found:
        reason = finding.advice or kind
        where = finding.traceback.splitlines()[-2:-1]
        groups.setdefault((kind, finding.status, reason, *where), []).append(finding)
    listed = [replace(group[0], count=len(group)) for group in groups.values()]
    return tuple(sorted(listed, key=lambda one: one.status is not Status.FAIL))
