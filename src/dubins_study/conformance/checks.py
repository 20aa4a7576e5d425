"""The checks, in the order of a report: simple questions first."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import NamedTuple

from dubins_study.conformance import behaviour, questions
from dubins_study.conformance.answers import Kind, Problem, problems, unanswered, united
from dubins_study.conformance.findings import CheckResult, Finding, Status
from dubins_study.conformance.interview import Interview, Seen
from dubins_study.conformance.patterns import of_another_question, of_one_side
from dubins_study.solvers.protocol import Question
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Verdict


class Check(NamedTuple):
    """One check: what it looks at, and the function that does."""

    title: str
    run: Callable[[Interview, str, str], CheckResult]


def _asked(
    scenarios: Mapping[str, Scenario], kinds: tuple[Kind, ...] = tuple(Kind)
) -> Callable[[Interview, str, str], CheckResult]:
    """A check that asks for the best path of scenarios, and reports problems of some kinds.

    A question that this check is the first to ask, and that is not answered, is reported too.
    """

    def run(interview: Interview, name: str, title: str) -> CheckResult:
        if not interview.answers("best"):
            return _not_applicable(name, title, "the solver does not answer `best`")
        shown: list[Problem] = []
        answers: list[Seen] = []
        for label, scenario in scenarios.items():
            before = len(interview.seen)
            answers.append(interview.ask(Question(scenario)))
            wanted = {*kinds, Kind.OUTCOME} if len(interview.seen) > before else kinds
            answer_problems = problems(answers[-1], label, interview.declared["guarantee"])
            explained = (
                of_another_question(interview.seen, answers[-1], one) for one in answer_problems
            )
            shown += [one for one in explained if one.kind in wanted]
        shown = of_one_side(answers, shown)
        if Kind.CONTROLS in kinds and not shown and all(one.answer.path is None for one in answers):
            return _not_applicable(name, title, "it returned no path")
        return CheckResult(name, title, united(shown), f"{len(scenarios)} questions")

    return run


def _changed(
    scenarios: Mapping[str, Scenario],
) -> Callable[[Interview, str, str], CheckResult]:
    """A check that asks a question that was changed, and says if only the change is answered wrong.

    The shortest path changes with the question, and so should the solver's answer.
    """
    ask = _asked(scenarios)

    def run(interview: Interview, name: str, title: str) -> CheckResult:
        result = ask(interview, name, title)
        if not result.findings or _wrong(interview, questions.REFERENCE):
            return result
        advice = "the same question is answered rightly before it is changed in this way"
        findings = [
            finding if finding.advice else replace(finding, advice=advice)
            for finding in result.findings
        ]
        return replace(result, findings=tuple(findings))

    return run


def _wrong(interview: Interview, scenario: Scenario) -> bool:
    return interview.ask(Question(scenario)).answer.verdict is not Verdict.OPTIMAL


def _branches(interview: Interview, name: str, title: str) -> CheckResult:
    """Every word that the solver declares, where a path of it exists and where none does."""
    words = [word for word in questions.WORDS if interview.answers(word)]
    if not words:
        return _not_applicable(name, title, "the solver answers `best` only")
    word_problems: list[Problem] = []
    for word in words:
        scenarios = {f"{word}, question {n}": q for n, q in enumerate(questions.WORDS[word], 1)}
        scenarios[f"{word}, which has no path here"] = questions.WITHOUT[word]
        for label, scenario in scenarios.items():
            seen = interview.ask(Question(scenario, word))
            word_problems += problems(seen, label, interview.declared["guarantee"])
    return CheckResult(name, title, united(word_problems), ", ".join(words))


def _bounds(interview: Interview, name: str, title: str) -> CheckResult:
    """The lower bounds of all answers so far; of the usual questions if none was asked yet."""
    before = len(interview.seen)
    if interview.answers("best"):
        for scenario in _BOUNDED.values():
            interview.ask(Question(scenario))
    else:
        for word in filter(interview.answers, questions.WORDS):
            for scenario in questions.WORDS[word]:
                interview.ask(Question(scenario, word))
    silent = unanswered(interview.seen[before:], "")
    with_bound = [
        seen
        for seen in interview.seen
        if seen.answer.lower_bound is not None or seen.answer.false_bound
    ]
    if not (with_bound or silent):
        return _not_applicable(name, title, "the solver gives no lower bounds")
    bound_problems = [
        problem
        for seen in with_bound
        for problem in problems(seen, questions.name_of(seen.question.scenario), "")
        if problem.kind is Kind.BOUND
    ]
    return CheckResult(name, title, (*silent, *united(bound_problems)), f"{len(with_bound)} bounds")


# What a full set of checks has asked before it looks at the bounds.
_BOUNDED = questions.GENERAL | questions.AXIS | questions.DISCS | questions.CIRCLES


def _not_applicable(name: str, title: str, reason: str) -> CheckResult:
    return CheckResult(name, title, (), reason, Status.NOT_APPLICABLE)


def _warm(interview: Interview, name: str, title: str) -> CheckResult:
    """Initial guesses that help, mislead and are empty."""
    if not (interview.declared["warm"] and interview.answers("best")):
        return _not_applicable(name, title, "the solver takes no initial guess")
    scenario = questions.REFERENCE
    start, radius = scenario.start, scenario.radius
    guesses = {
        "the shortest path of a near target": shortest_path(questions.NEAR),
        "a path to elsewhere": Path(
            start, [1 / radius, 0.0, -1 / radius], [radius, radius, radius]
        ),
        "a path of no arcs": Path(start, [], []),
    }
    guess_problems: list[Problem] = []
    for label, guess in guesses.items():
        seen = interview.ask(Question(scenario, initial_guess=guess))
        guess_problems += problems(seen, f"initial guess: {label}", interview.declared["guarantee"])
    return CheckResult(name, title, united(guess_problems), f"{len(guesses)} initial guesses")


def _frames(interview: Interview, name: str, title: str) -> CheckResult:
    """The general questions as one frame: as right as one by one."""
    if not (interview.declared["whole_frames"] and interview.answers("best")):
        return _not_applicable(name, title, "the solver has no solve_frame")
    scenarios = questions.GENERAL | questions.AXIS | questions.DISCS
    row_questions = [Question(scenario) for scenario in scenarios.values()]
    row_problems: list[Problem] = []
    for label, seen in zip(scenarios, interview.ask_frame(row_questions), strict=True):
        row_problems += problems(seen, f"in a frame: {label}", interview.declared["guarantee"])
    return CheckResult(name, title, united(row_problems), f"{len(row_questions)} rows")


_TABLE = {
    "outcome": Check(
        "returns a Solution, and neither raises, crashes nor hangs",
        _asked(questions.GENERAL, (Kind.OUTCOME,)),
    ),
    "controls": Check(
        "paths start at the start, keep the radius and arrive",
        _asked(questions.GENERAL, (Kind.CONTROLS,)),
    ),
    "claims": Check(
        "claims of optimality, of a bound, of no path; paths that are longer",
        _asked(questions.GENERAL, (Kind.CLAIM, Kind.LENGTH, Kind.BOUND)),
    ),
    "axis": Check("targets straight ahead, straight behind, at the start", _asked(questions.AXIS)),
    "discs": Check(
        "targets within a turning disc, where RL or LR is shortest", _asked(questions.DISCS)
    ),
    "circles": Check("targets on and near a turning circle", _asked(questions.CIRCLES)),
    "symmetries": Check("mirrored, moved and turned questions", _changed(questions.SYMMETRIES)),
    "scale": Check("one question larger, smaller, farther, faster", _changed(questions.SCALES)),
    "branches": Check("the words that it declares", _branches),
    "bounds": Check("lower bounds are below the shortest length", _bounds),
    "warm": Check("initial guesses, good and bad", _warm),
    "frames": Check("whole frames of scenarios", _frames),
    "limits": Check("returns by its time limit", behaviour.limits),
    "determinism": Check("the same question has the same answer", behaviour.determinism),
    "state": Check("leaves its process as it was", behaviour.state),
}
CHECKS = ("loading", *_TABLE)


def run_check(interview: Interview, name: str) -> CheckResult:
    """The result of one of `CHECKS`, all but `loading`, which precedes the interview."""
    check = _TABLE[name]
    return check.run(interview, name, check.title)


def title_of(name: str) -> str:
    """What a check looks at."""
    return "loads, and says what it is" if name == "loading" else _TABLE[name].title


def failed(name: str, finding: Finding) -> CheckResult:
    """The result of a check that failed for one reason."""
    return CheckResult(name, title_of(name), (finding,))


def unfinished(name: str, seen: list[Seen], reason: str) -> CheckResult:
    """The result of a check that was cut short: what failed until then, or that it was not made."""
    not_asked = [
        problem
        for one in seen
        for problem in problems(one, questions.name_of(one.question.scenario), "")
        if problem.kind is Kind.OUTCOME
    ]
    return CheckResult(name, title_of(name), united(not_asked), reason, Status.NOT_ASKED)
