"""What all transcriptions of problem (2.2) share: settings, initial guesses, search, answer."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain
from time import perf_counter
from typing import ClassVar, NamedTuple, Protocol

import numpy as np

from dubins_study.solvers.answers import (
    Attempts,
    Run,
    best_of,
    costs,
    in_world,
    staying,
    total,
    tried,
)
from dubins_study.solvers.engines import ENGINES, NLP_ENGINES, EngineSolver
from dubins_study.solvers.nlp_engines.program import EngineResult
from dubins_study.solvers.optimal_control.arcs import (
    HERE,
    LEAST,
    RATES,
    Elements,
    Rates,
    closed,
    cut,
    miss,
)
from dubins_study.solvers.paper_nlp.initial_guesses import INITIAL_GUESSES
from dubins_study.solvers.paper_nlp.model import FULL_TURN
from dubins_study.solvers.paper_nlp.polish import one_sided_only
from dubins_study.solvers.presolve import nearer_first
from dubins_study.solvers.protocol import Guarantee, Method, Question, Solution
from dubins_study.solvers.setting_checks import one_of, whole, within
from dubins_study.study.body_coordinates import Local, local
from dubins_study.study.path import FloatArray, Path, drivable
from dubins_study.study.words import Claim

_ARRIVED = 1e-8  # radii; a hundredth of what the check allows
_ROUNDED = 32 * math.ulp(1.0)  # of the target's distance
_SAME = (
    1e-6  # relative; of two answers this near, the one that its engine calls a solution is taken
)


class Transcribed(NamedTuple):
    """An engine's solution of a transcription; the duals (2,) are those of the end point."""

    elements: Elements
    native: EngineResult


class Template(Protocol):
    """A transcription, compiled for its settings."""

    @property
    def shares(self) -> FloatArray | None:
        """Shares of the whole length that the elements have, shape (n,); None if free."""

    def solve(self, guess: Elements, rates: Rates, target: FloatArray, until: float) -> Transcribed:
        """Solve for a target (2,) in radii from a guess until a time (s, on `perf_counter`)."""


class Model(NamedTuple):
    """A question in body coordinates, in radii."""

    question: Question
    place: Local
    rates: Rates
    template: Template

    @property
    def target(self) -> FloatArray:
        """Shape (2,)."""
        return np.array((self.place.X, self.place.Y))


@dataclass(frozen=True)
class Transcription(EngineSolver):
    """Problem (2.2) of the paper over n elements, each of one turn rate.

    The engine's controls are integrated exactly; where the path misses by the transcription's own
    error or the engine's tolerance, a last correction removes the miss. `LS` and `RS` forbid
    turning the other way. For `best`, the engine starts from the shape of every word, and the
    shortest path is the answer.

    Args:
        n: number of elements.
        engine: a name in `solvers.engines` of the kind `local NLP`.
        mesh: `free` elements, whose lengths are variables, so that a switch falls between two of
            them and the gap is the engine's tolerance; or `equal` ones, whose gap falls like
            1 / n^2.
        initial_guess, seed, count: where the search begins (`trials`).
        correct: whether a last correction removes the miss.
        tol, max_iter: the engine's own.
        presolve: whether no guess is shaped like a word that cannot exist (`solvers.presolve`).
    """

    # Three elements hold every word: an arc of up to a full turn takes two free elements. A
    # thousand take minutes.
    n: int = whole(5, 3, 1000)
    engine: str = one_of("ipopt", NLP_ENGINES)
    mesh: str = one_of("free", ("free", "equal"))
    initial_guess: str = one_of("bearing", INITIAL_GUESSES)
    seed: int = whole(0, 0, 2**32)
    count: int = whole(10, 1, 10**6)
    correct: bool = True
    tol: float = within(1e-9, 1e-14, 1e-2)
    max_iter: int = whole(200, 1, 10**6)
    presolve: bool = False

    formulation: ClassVar[str]
    guarantee: ClassVar[Guarantee] = Guarantee.DISCRETISED
    branches: ClassVar[tuple[str, ...]] = tuple(RATES)
    warm: ClassVar[bool] = True

    @property
    def method(self) -> Method:
        engine = ENGINES[self.engine]
        tol = engine.fixed_tol or self.tol
        return Method(self.formulation, engine.label, self.initial_guess, tol)

    def template(self, distance: float) -> Template:
        """The compiled transcription for a target so far away (radii)."""
        raise NotImplementedError

    def build(self, question: Question) -> Model:
        place = local(question.scenario)
        template = self.template(math.hypot(place.X, place.Y))
        return Model(question, place, RATES[question.branch], template)

    def solve(self, model: Model, limit: float) -> Solution:
        question, place, rates, template = model
        if place.X == place.Y == 0:
            return staying(question)
        until = perf_counter() + limit
        shapes = nearer_first(question, self.presolve, place.Y)
        kind = Kind(self.initial_guess, self.seed + question.repeat, self.count)
        run = partial(self._run, model)
        every = self.initial_guess == "random"
        each = (
            Attempts(guesses, run, lambda _: not every)
            for guesses in trials(question, place, shapes, self.n, template.shares, rates, kind)
        )
        return _answer(model, tried(each, until), in_time=perf_counter() <= until)

    def _run(self, model: Model, guess: Guess, until: float) -> Run[Elements]:
        began, target = perf_counter(), model.target
        elements, native = model.template.solve(guess.elements, model.rates, target, until)
        # what is optimal for a transcription is not proven for the problem itself
        claim = Claim.LOCAL if native.claim is Claim.OPTIMAL else native.claim
        missed, off, rollouts = math.inf, math.inf, 0
        if not (np.isfinite(elements.turn).all() and np.isfinite(elements.length).all()):
            claim = Claim.FAILED
        else:
            missed, rollouts = miss(elements, target), 1
            off = missed
            if self.correct:
                fixed = model.template.shares is not None
                elements, off, rollouts = closed(elements, model.rates, target, fixed)
                if claim is Claim.LOCAL and not _arrives(off, target):
                    claim = Claim.FAILED
        result = native._replace(
            claim=claim,
            evaluations=total((native.evaluations, rollouts)),
            message=f"{native.message}; missed by {missed:.1e} radii before the correction",
        )
        seconds = perf_counter() - began
        return Run(guess.subproblem, seconds, elements, *result[1:], elements.total, off)


def _arrives(off: float, target: FloatArray) -> bool:
    return off <= max(_ARRIVED, _ROUNDED * float(np.abs(target).sum()))


def _answer(model: Model, runs: list[Run[Elements]], in_time: bool) -> Solution:
    """The shortest run that arrives, or else the one that ends nearest to the target.

    Of equally short runs one that the engine calls a solution goes first.
    """
    if not runs:
        return Solution(Claim.LIMIT, message="no time to begin")
    scenario, rates = model.question.scenario, model.rates
    arrived = [run for run in runs if run.claim is Claim.LOCAL or _arrives(run.miss, model.target)]
    shortest = min((run.length for run in arrived), default=math.inf)
    tied = [run for run in arrived if run.length <= shortest * (1 + _SAME)]
    best = best_of([run for run in tied if run.claim is Claim.LOCAL] or tied, runs)
    claim, message = best.claim, best.message
    if not in_time:
        claim = Claim.LIMIT
    elif claim is not Claim.LOCAL and _arrives(best.miss, model.target):
        # the engine gave up, or wrongly called it infeasible, but the corrected path arrives
        claim = Claim.FEASIBLE
    elif claim is not Claim.LOCAL:
        none = {run.claim for run in runs} == {Claim.INFEASIBLE}
        claim = Claim.INFEASIBLE if none else Claim.FAILED
    path = None
    if math.isfinite(best.miss) and claim is not Claim.INFEASIBLE:
        rate = np.clip(best.point.rate, rates.lower, rates.upper)
        path = Path(scenario.start, rate / scenario.radius, best.point.length * scenario.radius)
        if claim in (Claim.LOCAL, Claim.FEASIBLE) and (
            reason := one_sided_only(model.question, path)
        ):
            claim, message = Claim.FAILED, reason
    duals = best.duals if claim is Claim.LOCAL else None
    return Solution(
        claim,
        path=path,
        claimed_length=None if path is None else best.length * scenario.radius,
        multipliers=None if duals is None else in_world(scenario, duals),
        native_status=best.status,
        message=message,
        best_run=best.effort,
        **costs(runs),
    )


# arcs (rad) of RL and LR: the second exceeds pi where it can be shortest, the first is at most
# pi/3 (docs/derivation.md, section 4)
_TWO_ARCS = ((0.5, 4.5), (0.1, 6.0), (0.9, 3.5))
# rad, added to the turn towards the target where the first guess fails
_SWINGS = (0.7, -0.7)
# rad, to which the rounding of the bearing is added: a bearing so near to a full turn is straight
# ahead
_STRAIGHT = 1e-9


class Guess(NamedTuple):
    """An initial guess, and the word whose shape it has, or `warm`, `zero` or `random`."""

    subproblem: str
    elements: Elements


class Kind(NamedTuple):
    """Where a search begins: the settings `initial_guess`, `seed` and `count`."""

    name: str = "bearing"
    seed: int = 0
    draws: int = 10


def trials(
    question: Question,
    target: Local,
    shapes: Sequence[str],
    n: int,
    shares: FloatArray | None,
    rates: Rates,
    kind: Kind = Kind(),  # noqa: B008  (frozen)
) -> Iterator[Iterator[Guess]]:
    """Initial guesses, subproblem by subproblem, of n elements with `shares` (n,) of the length.

    The question's own path goes first if it can be driven: among the guesses of the word that is
    asked for, or alone if the branch is `best`. The others are shaped like each of the words
    `shapes` (kind `bearing`), or have no turn and no length (`zero`, AMPL's default), or are drawn
    at random within the `rates`, up to twice the target's distance, a turning circle's length and
    its diameter long. Kind `given` has the question's own path only, if there is one. Without
    shares the elements' lengths are free.
    """
    warm = [Guess("warm", cut(path, n, shares)) for path in _given(question)]
    if kind.name == "given" and warm:
        yield iter(warm)
        return
    if kind.name == "zero":
        cold = [iter([Guess("zero", Elements(np.zeros(n), np.zeros(n)))])]
    elif kind.name == "random":
        cold = [_random(question, target, n, shares, rates, kind)]
    else:
        cold = _words(question, target, shapes, n, shares)
    if question.branch == "best":
        if warm:
            yield iter(warm)
        yield from cold
        return
    (only,) = cold
    yield chain(warm, only)


def _words(
    question: Question, target: Local, shapes: Sequence[str], n: int, shares: FloatArray | None
) -> list[Iterator[Guess]]:
    def shaped(word: str) -> Iterator[Guess]:
        return (Guess(word, cut(path, n, shares)) for path in _shaped(word, target))

    if question.branch != "best":
        return [shaped(question.branch)]
    return [shaped(word) for word in shapes]


def _random(
    question: Question,
    target: Local,
    n: int,
    shares: FloatArray | None,
    rates: Rates,
    kind: Kind,
) -> Iterator[Guess]:
    random = np.random.default_rng((kind.seed, question.repeat))
    longest = 2 * math.hypot(target.X, target.Y) + 2 + FULL_TURN
    for _ in range(kind.draws):  # one by one: time may be up long before the last
        if shares is None:
            length = random.uniform(0.0, 2 * longest / n, n)
        else:
            length = shares * random.uniform(0.0, longest)
        yield Guess(
            "random", Elements(random.uniform(rates.lower, rates.upper, n) * length, length)
        )


def _given(question: Question) -> Iterator[Path]:
    """The question's path in body coordinates at unit radius, if it can be driven."""
    path, radius = question.initial_guess, question.scenario.radius
    if path is not None and drivable(path) and path.total_length > 0:
        yield Path(HERE, path.curvature * radius, path.length / radius)


def _shaped(word: str, target: Local) -> Iterator[Path]:
    """Paths shaped like a word: two arcs, or a turn and a straight.

    The first turn faces the target; the second is larger by half the apparent size of a turning
    circle there; others follow.
    """
    sign = 1.0 if word[0] == "L" else -1.0
    if word[1] != "S":
        yield from (Path(HERE, (sign, -sign), arcs) for arcs in _TWO_ARCS)
        return
    distance = math.hypot(target.X, target.Y)
    facing = (sign * math.atan2(target.Y, target.X)) % FULL_TURN
    if facing > FULL_TURN - _STRAIGHT - 2 * target.delta / distance:
        facing = 0.0
    distance = max(distance, LEAST)
    aim = facing + math.atan(1 / distance)
    for turn in (facing, aim, *(aim + swing for swing in _SWINGS)):
        arc = turn % FULL_TURN
        lengths = (max(arc, LEAST), distance)
        yield Path(HERE, (sign * arc / lengths[0], 0.0), lengths)
