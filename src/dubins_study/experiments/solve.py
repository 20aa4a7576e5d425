"""One question or a frame, put to a solver.

The solver is asked in this process, or in a worker of its own.
"""

from __future__ import annotations

import logging
import signal
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING

from dubins_study.asking.attempt import Answer, QuestionError, attempt, check_branch, check_request
from dubins_study.asking.reply import DEFAULT_LIMIT
from dubins_study.experiments.interruption import Interruption
from dubins_study.solvers.analytic import Analytic
from dubins_study.solvers.protocol import Question, Solver
from dubins_study.solvers.registry import load, ours
from dubins_study.study.path import Path
from dubins_study.study.scenario import LARGEST_EXTENT, Scenario
from dubins_study.study.tolerances import tolerances
from dubins_study.study.units import doubtful_units
from dubins_study.study.values import short

if TYPE_CHECKING:
    import pandas as pd

    from dubins_study.experiments.plan.solver_description import SolverDescription

_LOG = logging.getLogger(__name__)


def solve(
    scenario: Scenario,
    solver: str = "analytic",
    branch: str = "best",
    *,
    profile: str = "default",
    initial_guess: Path | None = None,
    limit: float = DEFAULT_LIMIT,
    isolated: bool | None = None,
) -> Answer:
    """Solve one scenario and judge the answer.

    Args:
        scenario: start pose, via points, target, final heading, turning radius, speed.
        solver: a spec, e.g. `ipopt`, `turn-rate-qp[n=100]` or `file.py:Class`.
        branch: `best`, or a word: `LS`, `RS`, `LR`, `RL`; with a final heading `LSL`, `RSR`,
            `LSR`, `RSL`, `RLR`, `LRL`; of a route only `best`.
        profile: `default`, `fast` or `accurate`.
        initial_guess: a path to begin the search from, of any shape; cold if None. Refused for a
            solver that does not use one, and if it cannot be driven. A solver that asks word by
            word takes it for the words that it fits.
        limit: seconds that the solver is asked to keep to, once its libraries are loaded. The
            check's own search for the shortest route ends after as many, or 20.
        isolated: whether the solver is asked in a worker process. The process is killed a tenth of
            a second after the limit, or above 4 GiB; that, a crash and a hang are then outcomes, as
            in a run. With False the solver is asked in this process, and this returns when the
            solver does. With None a worker is used unless the solver promises to keep its limit
            (`Solver.keeps_limit`). Most solvers of this package promise it; those of tours by
            engines do not, and a plug-in does not unless it says so. `analytic` is always asked in
            this process. A worker takes less than 0.1 s to start, the first one 0.3 s. Each loads
            the solver's libraries anew: this takes 0.3 to 0.6 s, and a second for cvxpy.

    Raises:
        SolverError, ProfileError, QuestionError: if the request is not a valid one. A solver that
            fails raises nothing: it is an outcome, a claim and a verdict.
        RunError, ForkServerError: if no worker process can be started.
    """
    check_request(branch, limit)
    limit = float(limit)
    if not isinstance(scenario, Scenario):
        raise QuestionError(f"scenario is {scenario!r}; expected a Scenario")
    if initial_guess is not None and not isinstance(initial_guess, Path):
        kind = type(initial_guess).__name__
        raise QuestionError(f"initial_guess is of type {kind}; expected a Path or None")
    check_branch(scenario, branch)
    if doubt := doubtful_units(scenario):
        _LOG.warning("dubins-study: %s", doubt)
    question = Question(scenario, branch, initial_guess)
    if initial_guess is not None and question.guess_in_radii is None:
        raise QuestionError(
            "initial_guess cannot be driven; expected finite numbers, no negative length, and at "
            f"most {LARGEST_EXTENT:g} for its length in radii and its turn in rad together"
        )
    allowed = tolerances(profile, limit)
    described = _described(solver, profile)
    if initial_guess is not None and not described.warm:
        raise QuestionError(f"solver {solver!r} takes no initial_guess; expected None")
    if _in_worker(described, isolated):
        from dubins_study.experiments.executors.local import ask_isolated

        [answer] = ask_isolated(solver, profile, [question], limit)
        return answer
    if not isinstance(described, Solver):
        described = load(solver, profile)
    with _ctrl_c():
        return attempt(described, question, limit, allowed, spec=solver)


def solve_frame(
    scenarios: pd.DataFrame,
    solver: str = "analytic",
    branch: str = "best",
    *,
    profile: str = "default",
    limit: float = DEFAULT_LIMIT,
    certified: bool = False,
    isolated: bool | None = None,
) -> pd.DataFrame:
    """Solve and judge every scenario of a frame.

    Args:
        scenarios: columns `x y heading target_x target_y radius`, and `speed`, `label`, `via_x`,
            `via_y` and `final_heading` if wanted. There is one row a scenario, with values as
            `Scenario` takes them; a final heading that is missing is free. A row's via points are
            two lists of as many numbers. Columns of answers are left out, all others are carried
            along.
        solver: a spec, e.g. `ipopt` or `turn-rate-qp[n=100]`.
        branch: as for `solve`; each row must be able to have it.
        profile: `default`, `fast` or `accurate`.
        limit: seconds that the solver is asked to keep to, for each scenario.
        certified: whether a solver that answers the whole frame at once has its answers certified
            too, at some 0.15 ms a row. Without, the certificate's numbers are null and its flags
            False. A solver that is asked row by row always has its answers certified.
        isolated: as for `solve`, with one worker for all rows, which is replaced when it is
            killed. With None, a solver that answers the whole frame at once does so in this
            process, without a limit; with True it is asked row by row.

    Returns:
        One judged row a scenario with the index of `scenarios`: the columns of `study.rows.schema`
        from `x` to `best_run_s`, whatever the solver, and those carried along. Missing numbers are
        null.
        A solver that answers a whole frame at once answers its rows with a free final heading, and
        then those with a given one. Each row's times are the times of all rows of its kind, divided
        by their number. Routes are answered row by row.

    Raises:
        ScenarioError, SolverError, ProfileError, QuestionError: if the request is not a valid one.
        RunError, ForkServerError: if no worker process can be started.
    """
    from dubins_study.asking import frame

    check_request(branch, limit)
    limit = float(limit)
    tolerances(profile)
    if not _in_worker(_described(solver, profile), isolated, frames=True):
        with _ctrl_c():
            return frame.solve_frame(
                scenarios, solver, branch, profile=profile, limit=limit, certified=certified
            )
    from dubins_study.experiments.executors.local import ask_isolated

    checked, others = frame.checked(scenarios)
    frame.check_branches(checked, branch)
    questions = frame.questions(checked, branch)
    rows = frame.row_by_row(checked, ask_isolated(solver, profile, questions, limit))
    return frame.with_others(rows, others)


def _described(spec: str, profile: str) -> Solver | SolverDescription:
    """The solver of a spec, or a plug-in's description.

    A plug-in is not loaded in this process to describe it.
    """
    if ours(spec):
        return load(spec, profile)
    from dubins_study.experiments.plan.solver_description import describe_solver

    return describe_solver(spec, profile)


def _in_worker(
    solver: Solver | SolverDescription, isolated: bool | None, *, frames: bool = False
) -> bool:
    """Whether a solver is asked in a worker process.

    `analytic` never is. For others `isolated` decides; if it is None, a worker is used unless the
    solver keeps its limit. With `frames`, a plug-in that answers whole frames needs none either.
    """
    if isolated is not None and not isinstance(isolated, bool):
        raise QuestionError(f"isolated is {short(isolated)}; expected True, False or None")
    if isinstance(solver, Analytic):
        return False
    if isolated is not None:
        return isolated
    whole_frames = not isinstance(solver, Solver) and solver.whole_frames
    return not (solver.keeps_limit or (frames and whole_frames))


def _ctrl_c() -> AbstractContextManager[object]:
    """A `with` block that Ctrl-C ends.

    If a library swallows the KeyboardInterrupt, as casadi does, the block's end raises it. If the
    caller has a handler for Ctrl-C, nothing is changed.
    """
    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        return nullcontext()
    return Interruption((signal.SIGINT,), at_once=True)
