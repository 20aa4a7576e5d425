"""One attempt: a question, an answer and its judgement.

The caller times the solver. The check judges its answer.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from operator import attrgetter
from time import monotonic
from typing import Any

from dubins_study.asking.reply import DEFAULT_LIMIT, Reply, ask, with_possible_times
from dubins_study.errors import DubinsStudyError
from dubins_study.solvers.protocol import NOT_STATED, Method, Question, Solution, Solver
from dubins_study.solvers.registry import stated_method
from dubins_study.study.judging.certify import certify
from dubins_study.study.judging.judge import judge
from dubins_study.study.kinds.table import (
    EVERY_BRANCH,
    PATH_BRANCHES,
    branches_of,
    kind_of,
    pathless_kind_of,
    prepare,
    reference_of,
)
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import (
    ANSWER,
    SCENARIO,
    Certificate,
    Judgement,
    Reported,
    Spent,
    Times,
    columns,
    names,
)
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import DEFAULT, PROFILES, Tolerances
from dubins_study.study.values import did_you_mean, plain, real_number, short
from dubins_study.study.words import (
    Claim,
    Order,
    Outcome,
    Proof,
    Verdict,
    short_word,
)

_FOR_A_PLANNER = (
    "length",
    "travel_time",
    "path",
    "word",
    "verdict",
    "proof",
    "order",
    "visits",
    "reference_low",
    "reference_high",
    "certificate",
    "scenario",
    "row",
)
_REPR_CHARS = 96  # in a line of an answer's repr


@dataclass(frozen=True, kw_only=True, repr=False)
class Answer(Spent, Times, Certificate, Judgement, Reported):
    """A judged and certified attempt.

    Units are those of `study.rows.schema`.

    The check computes its columns from the path's controls; `claimed_length` is the solver's own.
    """

    scenario: Scenario
    solver: str
    branch: str
    formulation: str
    engine: str
    guess: str
    guesses: str
    presolve: bool
    knows: str
    tolerance: float | None
    proves: float | None
    outcome: Outcome

    def __repr__(self) -> str:
        word = self.word
        if word is not None:
            word = short_word(word, 16)
        lines = [
            f"length {self.length}, travel time {self.travel_time}, word {word}",
            f"verdict {self.verdict}, proof {self.proof}, claim {self.claim}",
            _scenario_text(self.scenario),
            f"gap {self.gap}, miss {self.miss}",
        ]
        if self.margin is not None:
            lines.append(f"region {self.region}, margin {self.margin:g}")
        lines += [
            f"build {self.build_s} s, solve {self.solve_s} s",
            f"message {plain(self.message)}",
            f"solver {self.solver}, branch {self.branch}, outcome {self.outcome}",
        ]
        text = "\n".join(f"  {line[:_REPR_CHARS]}" for line in lines)
        return f"Answer(\n{text})"

    def __dir__(self) -> tuple[str, ...]:
        """The names that `dir` lists.

        They are those that a planner needs. Every other column is reached by its name.
        """
        return _FOR_A_PLANNER

    @property
    def certificate(self) -> Certificate:
        """The answer's proof and the evidence for it."""
        return Certificate(**{name: getattr(self, name) for name in _CERTIFICATE})

    @property
    def order(self) -> list[int] | None:
        """The via points of a tour in visiting order.

        The first via point has number 0. None if the answer has no order.
        """
        if self.visit_order is None:
            return None
        return [int(place) for place in self.visit_order]

    def _repr_svg_(self) -> str | None:
        """The path's drawing for notebooks, as SVG text.

        Its caption has the verdict, the length, the proof and the word. None without a path.
        """
        if self.path is None or self.length is None:
            return None
        word = short_word(self.word or "", 24)
        caption = f"{self.verdict}, length {self.length:.6g}, proof {self.proof}, {word}"
        return self.path._drawing(caption)

    @property
    def tied_words(self) -> tuple[str, ...]:
        """The words that share the shortest length.

        There are two if the target is straight behind the vehicle, else one.
        """
        return kind_of(self.scenario, self.branch).ties(self.scenario, self.branch)

    @property
    def curvatures(self) -> list[float] | None:
        """The path's curvatures (1 / length unit), or None.

        None without a path, or if one of its curvatures or lengths is not finite.
        """
        return controls(self.path)[0]

    @property
    def lengths(self) -> list[float] | None:
        """The lengths of the path's arcs, or None.

        None without a path, or if one of its curvatures or lengths is not finite.
        """
        return controls(self.path)[1]

    def row(self) -> dict[str, Any]:
        """The row of the scenario and the answer.

        The keys are the columns of `study.rows.schema`. A number that is not finite is None.
        """
        scenario = dict(zip(_SCENARIO, _scenario_numbers(self.scenario), strict=True))
        return scenario | {name: getattr(self, name) for name in _ANSWER}


def _scenario_text(scenario: Scenario) -> str:
    heading = "free"
    if scenario.heading is not None:
        heading = f"{scenario.heading:g}"
    start = f"from ({scenario.x:g}, {scenario.y:g}, {heading})"
    via = ""
    if scenario.via:
        via = f" via {len(scenario.via)} points"
        if scenario.order is Order.FREE:
            via += " in any order"
    target = "any of them"
    if scenario.target is not None:
        numbers = [f"{number:g}" for number in scenario.stops[-1] if number is not None]
        target = f"({', '.join(numbers)})"
    return f"{start}{via} to {target}, radius {scenario.radius:g}, speed {scenario.speed:g}"


class QuestionError(DubinsStudyError, ValueError):
    """A question or limit that no solver takes."""


def check_branch(scenario: Scenario, branch: str) -> None:
    """Refuse a branch that the scenario cannot have.

    Such a branch is a QuestionError.
    """
    if branch not in branches_of(scenario):
        kind = kind_of(scenario)
        paths = ", ".join(kind.branches)
        raise QuestionError(f"branch {branch!r} is none of {kind.title}; choose one of: {paths}")


def check_request(branch: str, limit: float, limit_name: str = "limit") -> None:
    """Refuse an unknown branch or an impossible time limit.

    A time limit is a finite number of seconds above 0. Anything else is a QuestionError, which
    calls the limit by `limit_name`.
    """
    if not isinstance(branch, str) or branch not in EVERY_BRANCH:
        near = did_you_mean(branch, PATH_BRANCHES)
        choice = ", ".join(PATH_BRANCHES)
        raise QuestionError(f"no branch named {short(branch)}; {near}choose one of: {choice}")
    try:
        seconds = real_number(limit)
    except Exception:  # `float` of a value of any type may raise anything
        seconds = math.nan
    if not (math.isfinite(seconds) and seconds > 0):
        raise QuestionError(
            f"{limit_name} is {short(limit)}; expected a finite number of seconds above 0"
        )


def attempt(
    solver: Solver,
    question: Question,
    limit: float = DEFAULT_LIMIT,
    allowed: Tolerances = PROFILES["default"],
    spec: str | None = None,
) -> Answer:
    """Ask a solver, time it and judge its answer.

    An exception that the solver raises is judged as its answer. `limit` is in seconds, `allowed`
    are the check's tolerances. `spec` is the solver's name in the answer.
    """
    prepare(question.scenario, question.branch)
    began = monotonic()
    reply = ask(solver, question, limit)
    reply = with_possible_times(reply, waited_s=monotonic() - began)
    return judged(spec or solver.name, question, reply, allowed, stated_method(solver))


def judged(
    spec: str,
    question: Question,
    reply: Reply,
    allowed: Tolerances = PROFILES["default"],
    method: Method = NOT_STATED,
) -> Answer:
    """The answer of a reply, judged and certified.

    The check computes the verdict and the certificate; the reply's claim stands beside them.
    `spec` and `method` describe the solver. `allowed` are the check's tolerances.
    """
    solution = reply.solution
    scenario = question.scenario
    branch = question.branch
    path = solution.path
    pathless = pathless_kind_of(branch)
    if path is not None:
        prepare(scenario, branch)
    allowed = allowed.begun()  # the time of the check's searches runs from here
    if pathless is not None:
        tolerance = method.tolerance or allowed.gap
        judgement, certificate = pathless.judge(scenario, solution.point, solution.claim, tolerance)
    else:
        judgement = judge(scenario, path, solution.claim, branch, allowed)
        certificate = certify(
            scenario,
            path,
            judgement,
            branch,
            lower_bound=solution.lower_bound,
            multipliers=solution.multipliers,
            tolerances=allowed,
        )
    if solution.trace:
        judgement = _with_trace(judgement, question, solution, allowed)
    fields: dict[str, Any] = method.columns(question)
    fields |= vars(reply.times) | vars(judgement) | vars(certificate)
    # what the solver reports; numbers that are not finite become None
    fields |= {name: getattr(solution, name) for name in _REPORTED}
    fields |= {name: _finite(fields[name]) for name in _REPORTED_NUMBERS} | _spent(solution)
    if solution.presolved:  # no engine has proved anything, whatever the check finds
        fields["proof"] = Proof.NONE
    return Answer(
        scenario=scenario,
        solver=spec,
        branch=branch,
        outcome=reply.outcome,
        path=path,
        **fields,
    )


_SHORTER_KNOWN = (Verdict.LONGER, Verdict.MISSES, Verdict.NONE)


def shorter_answer(answer: Answer) -> Answer | None:
    """The shortest path that the check knows, judged.

    The result is None unless the answer's path is longer, misses the target or does not exist. For
    a branch that asks for no path the result is None too.
    """
    if answer.verdict not in _SHORTER_KNOWN or pathless_kind_of(answer.branch):
        return None
    at_once = replace(DEFAULT, until=-math.inf)  # the search was made when the answer was judged
    path = reference_of(answer.scenario, answer.branch, at_once).path
    reply = Reply(Outcome.RETURNED, Solution(Claim.NONE, path))
    return judged("the check", Question(answer.scenario, answer.branch), reply, at_once)


def controls(path: Path | None) -> tuple[list[float], list[float]] | tuple[None, None]:
    """Curvatures and lengths as a row holds them.

    Returns two lists. Both are None without a path, or if one of their numbers is not finite.
    """
    if path is None:
        return None, None
    curvatures = path.curvatures.tolist()
    lengths = path.lengths.tolist()
    if not all(map(math.isfinite, curvatures + lengths)):
        return None, None
    return curvatures, lengths


_SCENARIO = names(SCENARIO)
_ANSWER = names(ANSWER)
_CERTIFICATE = names(columns(Certificate))
_scenario_numbers = attrgetter(*_SCENARIO)


def _with_trace(
    judgement: Judgement, question: Question, solution: Solution, allowed: Tolerances
) -> Judgement:
    """The judgement with the columns of a trace.

    A path of the trace is listed if it arrives and is shorter than all listed before it. The
    columns hold its length, and the evaluations until then.
    """
    evaluations = []
    lengths = [math.inf]  # for the first comparison; left out at the end
    for count, path in solution.trace:
        step = judge(question.scenario, path, branch=question.branch, tolerances=allowed)
        if step.gap is not None and step.length is not None and step.length < lengths[-1]:
            evaluations.append(float(count))
            lengths.append(step.length)
    return replace(judgement, trace_evaluations=evaluations, trace_lengths=lengths[1:])


_REPORTED = names(columns(Reported))
_REPORTED_NUMBERS = [column.name for column in columns(Reported) if column.type == "float64"]


def _spent(solution: Solution) -> dict[str, Any]:
    """The columns of `Spent`, by name.

    A value that the solver does not report is None. The lists have one number for each subproblem;
    NaN stands for evaluations that were not counted.
    """
    best_run = solution.best_run
    values: dict[str, Any] = dict.fromkeys(_SPENT)
    if solution.multipliers is not None:
        values["multiplier_x"], values["multiplier_y"] = map(_finite, solution.multipliers)
    if solution.efforts:
        subproblems, runs, evaluations, seconds = zip(*solution.efforts, strict=True)
        values["subproblems"] = " ".join(subproblems)
        values["subproblem_runs"] = [float(number) for number in runs]
        values["subproblem_evaluations"] = [
            math.nan if count is None else float(count) for count in evaluations
        ]
        values["subproblem_s"] = list(seconds)
    if best_run is not None:
        values["best_run_evaluations"] = best_run.evaluations
        values["best_run_s"] = _finite(best_run.seconds)
    return values


_SPENT = names(columns(Spent))


def _finite(value: float | None) -> float | None:
    if value is None or not math.isfinite(value):
        return None
    return float(value)
