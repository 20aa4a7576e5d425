"""The conformance kit on known solvers, in this process."""

import itertools
import json
import math
import re
import signal
import time
from dataclasses import replace

import pytest

from dubins_study import Claim, Guarantee, Path, Solution, check_solver, solve
from dubins_study.conformance import CHECKS, interview
from dubins_study.conformance.checks import ConformanceError
from dubins_study.conformance.questions import (
    AXIS,
    CIRCLES,
    DISCS,
    GENERAL,
    OF_KIND,
    SCALES,
    SYMMETRIES,
    WITHOUT,
    WORDS,
    command,
)
from dubins_study.conformance.report import (
    ConformanceReport,
    Status,
    report_text,
)
from dubins_study.experiments.isolation.pool import GRACE_S as RUN_GRACE_S
from dubins_study.solvers.analytic import Analytic
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import SolverError
from dubins_study.study.closed_form.shortest import shortest, shortest_path
from dubins_study.study.kinds.table import reference_of
from dubins_study.study.tolerances import DEFAULT, ProfileError
from dubins_study.study.words import IN_ORDER

ANSWERS = [name for name in CHECKS if name not in ("limits", "state")]
TABLES = (GENERAL, AXIS, DISCS, CIRCLES, SYMMETRIES, SCALES)


class Right(Analytic):
    """The closed form as a plug-in."""

    solve_frame = None


class Confident(Right):
    """Looks at LS and RS only, and is sure."""

    branches = ("best",)
    takes = frozenset({"free final heading"})

    def solve(self, question, limit):
        answers = [
            super(Confident, self).solve(Question(question.scenario, word), limit)
            for word in ("LS", "RS")
        ]
        paths = [answer.path for answer in answers if answer.path is not None]
        return Solution(Claim.OPTIMAL, min(paths, key=lambda path: path.length))


class Careful(Confident):
    """The right solver, claiming only local optima."""

    def solve(self, question, limit):
        return Solution(Claim.LOCAL, super().solve(question, limit).path)


class Modest(Careful):
    """The right solver without the closed form's promise.

    It does not inherit the promise.
    """

    guarantee = Guarantee.LOCAL


class Raising(Right):
    """Does not know what to do."""

    def solve(self, question, limit):
        raise NotImplementedError("later")


class OfPoses(Right):
    """Answers one leg with a final heading alone."""

    takes = frozenset({"final heading"})


class OfRoutes(Right):
    """Answers via points in their order, nothing else."""

    takes = IN_ORDER


class OfTours(Right):
    """Answers via points in any order.

    They go from a heading that is given to a target or any point.
    """

    takes = IN_ORDER | {"free order"}


class Fixed(Right):
    """Ignores headings of points, and fixes free ones.

    It begins with one heading where it is free.
    """

    def solve(self, question, limit):
        scenario = question.scenario
        via = tuple(point[:2] for point in scenario.via)
        heading = 0.0 if scenario.heading is None else scenario.heading
        easier = replace(scenario, via=via, heading=heading)
        return super().solve(replace(question, scenario=easier), limit)


class InOrder(Right):
    """Passes the points of a tour in their order."""

    takes = IN_ORDER | {"free order"}

    def solve(self, question, limit):
        if question.scenario.target is not None:
            easier = replace(question.scenario, order="given")
            question = replace(question, scenario=easier)
        return super().solve(question, limit)


class OfNothing(Right):
    """Takes via points, but no target to end at."""

    takes = frozenset({"via points"})


class Denying(Right):
    """Denies paths of routes and final headings.

    They are all paths with via points or a final heading.
    """

    def solve(self, question, limit):
        if question.scenario.one_free_leg:
            return super().solve(question, limit)
        return Solution(Claim.INFEASIBLE)


class Silent(Denying):
    """The same, but claims nothing."""

    def solve(self, question, limit):
        return replace(super().solve(question, limit), claim=Claim.FAILED)


class Nearly(Right):
    """Ends a little too soon at final headings."""

    def solve(self, question, limit):
        path = super().solve(question, limit).path
        return Solution(Claim.LOCAL, replace(path, lengths=path.lengths * (1 - 1e-5)))


class OneWord(Right):
    """Answers RL only."""

    branches = ("RL",)


class Misled(Right):
    """Takes the initial guess for the answer."""

    warm = True

    def solve(self, question, limit):
        guess = question.initial_guess
        answer = super().solve(question, limit)
        return answer if guess is None else Solution(Claim.LOCAL, guess)


class Bounding(Right):
    """A bound above the length in the discs."""

    branches = ("best",)
    takes = frozenset({"free final heading"})

    def solve(self, question, limit):
        path = super().solve(question, limit).path
        grown = path.length * (1.01 if path.curvatures[-1:].any() else 1)
        return Solution(Claim.LOCAL, path, lower_bound=grown)


class Tiring(Right):
    """Changes the process's state in every solve alike."""

    branches = ("best",)

    def solve(self, question, limit):
        signal.signal(signal.SIGALRM, signal.SIG_IGN)
        return super().solve(question, limit)


class Timeless(Right):
    """Stops the clock."""

    branches = ("best",)

    def solve(self, question, limit):
        time.perf_counter = lambda: 0.0
        return super().solve(question, limit)


class Slow(Right):
    """Takes twice as long as a run permits.

    That holds whatever its limit.
    """

    branches = ("best",)
    keeps_limit = False

    def solve(self, question, limit):
        time.sleep(2 * RUN_GRACE_S + 0.05)
        return super().solve(question, limit)


class Hurried(Right):
    """Answers within its limit, but for two questions.

    It answers with what it has when its limit is over.
    """

    branches = ("best",)
    sure = ("target ahead to the left", "target behind to the right")

    def solve(self, question, limit):
        began = time.perf_counter()
        steps = 0
        if question.scenario.label in self.sure:
            return super().solve(question, limit)
        while time.perf_counter() < began + limit:
            steps += 1
        return Solution(Claim.FEASIBLE, Path(question.scenario.start, [0.0], [1.0 + steps]))


class AlwaysHurried(Hurried):
    """Answers every question so."""

    sure = ()


class HurriedAndMoody(Hurried):
    """Answers in time, with another length each time.

    It answers what it has time for.
    """

    mood = itertools.count()

    def solve(self, question, limit):
        path = super().solve(question, limit).path
        return Solution(Claim.LOCAL, Path(path.start, [0.0], [next(self.mood) + 1.0]))


class Idle(Right):
    """Finds nothing, and says so."""

    branches = ("best",)

    def solve(self, question, limit):
        return Solution(Claim.FAILED)


class OneWordRaising(OneWord):
    """Declares one word and does not answer it."""

    solve = Raising.solve


class Everything(Right):
    """Answers all that a solver may be asked."""

    warm = True
    guarantee = Guarantee.STOCHASTIC
    branches = ("best", *WORDS)


class Brief(Right):
    """Forgets the limit."""

    def solve(self, question):
        raise AssertionError


class Lost(Right):
    """Drives straight on, and is sure."""

    branches = ("best",)
    takes = Right.takes - {"free start heading"}

    def solve(self, question, limit):
        return Solution(Claim.OPTIMAL, Path(question.scenario.start, [0.0], [1.0]))


def checked(kind, checks=ANSWERS) -> ConformanceReport:
    return check_solver(kind, checks=checks, isolated=False)


def failed(report: ConformanceReport) -> set[str]:
    return {result.name for result in report if not result.passed}


def text(report: ConformanceReport, check: str) -> str:
    return " ".join(f"{one.observed} {one.advice}" for one in report[check].findings)


def test_a_right_solver_passes_without_a_note():
    report = checked(Right)

    assert report.passed, report
    assert report.with_status(Status.NOTE) == (), report
    assert report.answers["longer"] == report.answers["misses"] == 0
    assert report.answers["none exists"] == 4


def test_the_papers_claim_is_false_in_the_discs():
    """The paper's claim is false in the discs.

    It is false only there: LS or RS is the shortest everywhere else.
    """
    report = checked(Confident)

    assert failed(report) == {"discs", "circles"}, report
    assert "its path, RS, is 27.4 % longer than the shortest, RL" in text(report, "discs")
    assert "claim LOCAL unless the method proves" in text(report, "discs")


class Elsewhere(Right):
    """Claims an optimum and drives to another point."""

    def solve(self, question, limit):
        return Solution(Claim.OPTIMAL, Path(question.scenario.start, [0.0], [1.0]))


class Still(Elsewhere):
    """The same, and does not move."""

    def solve(self, question, limit):
        return Solution(Claim.OPTIMAL, Path(question.scenario.start, [0.0], [0.0]))


def test_a_false_claim_fails_the_check_of_claims():
    """A false claim fails the check of claims.

    It fails when asked alone too; what to do about it is told once.
    """
    assert "claims" in failed(checked(Elsewhere, ["claims"]))
    report = checked(Elsewhere, ["controls", "claims"])
    assert failed(report) >= {"controls", "claims"}
    advice = "drive your path with question.scenario.start"
    assert " ".join(str(report).split()).count(advice) == 1


def test_a_path_that_does_not_move_is_no_kept_answer():
    assert "does it keep answers" not in str(checked(Still))


def test_a_longer_path_is_a_note_of_an_honest_solver():
    """An honest solver's longer path is a note.

    The verdict says on how many questions, and how much longer the longest is.
    """
    report = checked(Modest)

    assert report.passed, report
    assert {one.name for one in report.with_status(Status.NOTE)} == {"discs", "circles"}
    gaps = []
    for scenario in [*DISCS.values(), *CIRCLES.values()]:
        best, *words = (shortest_path(scenario, branch) for branch in ("best", "LS", "RS"))
        excess = min(path.length for path in words if path is not None) - best.length
        gaps.append(excess / max(best.length, scenario.radius))
    worst = max(gaps)
    longer = report.answers["longer"]
    asked = sum(report.answers.values())
    shares = f"longer than the shortest on {longer} of {asked} questions, worst {100 * worst:.3g} %"
    assert shares in " ".join(str(report).split())
    assert "longer than" not in str(checked(Right, ["claims"]))


def test_a_longer_path_contradicts_a_guarantee():
    report = checked(Careful, ["discs"])

    assert "declares the guarantee 'exact'" in text(report, "discs")
    assert "declare another guarantee" in text(report, "discs")


def test_a_solver_that_answers_nothing_is_not_asked_further():
    report = checked(Raising)

    assert report["outcome"].status is Status.FAIL
    assert "raise NotImplementedError" in report["outcome"].findings[0].traceback
    assert "reply.py" not in report["outcome"].findings[0].traceback
    assert report["controls"].status is Status.NOT_ASKED
    assert "no question was answered so far" in " ".join(str(report).split())
    assert sum(report.answers.values()) == len(GENERAL)


def test_a_solver_of_one_word_is_asked_that_word():
    report = checked(OneWord)

    assert report.passed, report
    assert report["discs"].status is Status.NOT_APPLICABLE
    assert sum(report.answers.values()) >= len(WORDS["RL"]) + 1


def test_an_initial_guess_is_no_answer():
    report = check_solver(Misled, checks=["warm"], time_limit=2, isolated=False)

    assert report["warm"].status is Status.FAIL
    assert report["warm"].findings[0].question.startswith("initial guess: ")
    assert report["warm"].findings[0].count == 3
    assert report["warm"].findings[0].command.endswith(":Misled --check warm --time-limit 2")


def test_the_time_for_all_questions_is_a_bound():
    report = check_solver("analytic", isolated=False, total_time_limit=1e-9)

    assert not report.passed
    assert "raise --total-time-limit" in " ".join(str(report).split())


def test_the_report_as_json():
    report = checked(Confident, ["discs"])
    values = json.loads(json.dumps(report.to_dict(), allow_nan=False))

    assert values["passed"] is False
    assert [check["name"] for check in values["checks"]] == ["loading", "discs"]
    assert values["counts"] == {
        "fail": 1,
        "pass": 1,
        "note": 0,
        "not asked": 0,
        "not applicable": 0,
    }
    finding = values["checks"][1]["findings"][0]
    assert finding["count"] == 6
    assert finding["command"].startswith("dubins-study solve --time-limit 5 --solver ")
    assert finding["command"].endswith(" -- 0 1")


@pytest.mark.parametrize(
    ("request_", "error", "message"),
    [
        ({"solver": "slqsp"}, SolverError, "no solver named 'slqsp'; .*slsqp"),
        ({"solver": 3}, ConformanceError, "expected a spec, or a class that extends Solver"),
        ({"solver": int}, ConformanceError, "expected a spec, or a class that extends Solver"),
        ({"checks": ["disc"]}, ConformanceError, "no check named 'disc'; did you mean 'discs'"),
        (
            {"time_limit": 0},
            Exception,
            "time_limit is 0; expected a finite number of seconds above 0",
        ),
        ({"total_time_limit": math.nan}, Exception, "total_time_limit is nan"),
        ({"profile": "slow"}, ProfileError, "no profile named 'slow'"),
    ],
)
def test_requests_that_cannot_be_met(request_, error, message):
    with pytest.raises(error, match=message):
        check_solver(**({"solver": "analytic", "isolated": False} | request_))


def test_what_the_limit_cuts_off_need_not_be_the_same():
    """Answers cut off by the limit may differ.

    How far a search comes in its limit is the machine's doing; the rest is compared.
    """
    reports = [
        check_solver(kind, checks=["determinism"], time_limit=0.05, isolated=False)
        for kind in (Hurried, AlwaysHurried, HurriedAndMoody)
    ]
    hurried, always, moody = (report["determinism"] for report in reports)

    assert hurried.status is Status.PASS
    assert hurried.summary.startswith("4 pairs of answers the same; of 4 more pairs")
    assert always.status is Status.NOT_APPLICABLE
    assert "took the whole time limit" in always.summary
    assert moody.status is Status.FAIL


def test_an_error_of_the_check_is_not_the_solvers(monkeypatch):
    """An error of the check is not the solver's.

    It ends the interview with its own traceback; nothing is said of the solver.
    """
    monkeypatch.setattr(interview, "judged", lambda *_: 1 / 0)

    with pytest.raises(ZeroDivisionError):
        checked(Right, ["outcome"])


def test_the_spec_of_a_class():
    """The spec of a class.

    A registered one has its name; one inside a function has none.
    """

    class Hidden(Right):
        pass

    with pytest.raises(SolverError, match="has no class 'Hidden'"):
        check_solver(Hidden, isolated=False)
    assert check_solver(Analytic, checks=["loading"], isolated=False).solver == "analytic"


@pytest.mark.parametrize("word", WORDS)
def test_the_questions_of_words_are_what_they_are_for(word):
    """The questions of words suit their purpose.

    By the closed form each has a path of the word, some a shorter one of another word.
    """
    for scenario in WORDS[word]:
        assert shortest(scenario, word) is not None
    assert shortest(WITHOUT[word], word) is None
    assert any(shortest(scenario).word != word for scenario in WORDS[word])


def test_the_questions_are_where_they_say():
    assert all(solve(scenario).region in name for name, scenario in DISCS.items())
    assert all(solve(scenario).region == "outside" for scenario in GENERAL.values())
    for name, scenario in CIRCLES.items():
        wanted = "circle" if name.startswith("on") else "disc" if "inside" in name else "outside"
        assert wanted in solve(scenario).region, name
    for table in TABLES:
        assert all(scenario.label == name for name, scenario in table.items())


def test_a_command_holds_every_number_to_the_last_bit():
    scenario = SYMMETRIES["turned by 2 rad"]
    words = command("my solver.py:Mine[n=2]", Question(scenario, "RL"), 0.1, "fast").split()

    assert tuple(map(float, words[3:6])) == scenario.start
    assert words[6:-2] == [
        *("--radius", "0.4", "--speed", "0.6", "--branch", "RL", "--profile", "fast"),
        *("--time-limit", "0.1", "--solver", "'my", "solver.py:Mine[n=2]'", "--"),
    ]
    assert tuple(map(float, words[-2:])) == (scenario.target_x, scenario.target_y)


OF_ANY_BRANCH = ("limits", "determinism", "state", "branches")


@pytest.mark.parametrize(
    ("kind", "check"),
    [(Raising, check) for check in ("outcome", "controls", "claims", *OF_ANY_BRANCH)]
    + [(OneWordRaising, check) for check in OF_ANY_BRANCH],
)
def test_a_check_alone_does_not_pass_what_was_not_answered(kind, check):
    """A check alone fails a solver without answers.

    No check takes an exception for an answer, also where it is the only check.
    """
    report = checked(kind, [check])

    assert report[check].status is Status.FAIL, report
    assert "raised NotImplementedError: later" in text(report, check)


def test_a_false_bound_is_found_where_it_is_given():
    """A false bound is found.

    It may be false in the discs only.
    """
    report = checked(Bounding)

    assert failed(report) == {"discs", "circles"}
    assert "lies above the shortest length" in text(report, "discs")


@pytest.mark.parametrize(("kind", "changed"), [(Tiring, "signal handlers"), (Timeless, "clock")])
def test_a_change_that_every_solve_makes_alike_is_seen(kind, changed):
    """A change that every solve makes is seen.

    It runs in a new process, where what our own first path imports does not excuse the first
    solve.
    """
    report = check_solver(kind, checks=["state"])

    assert report["state"].status is Status.FAIL, report
    assert f"not as it was before: {changed}" in text(report, "state")


def test_checks_that_are_asked_for_alone_ask_what_they_look_at():
    report = checked(Right, ["state"])

    assert report["state"].summary == f"{len(GENERAL)} questions"


def test_a_solve_that_a_run_would_end_is_a_note():
    """Solves that a run would end are notes.

    A run ends it a tenth of a second after its limit; that is no promise of a plug-in.
    """
    report = checked(Slow, ["limits"])

    assert report["limits"].status is Status.NOTE, report
    assert "return the best path so far" in text(report, "limits")
    assert checked(Right, ["limits"])["limits"].status is Status.PASS


def test_a_solver_without_a_path_passes_no_check_of_paths():
    report = checked(Idle)

    assert report["controls"].status is Status.NOT_APPLICABLE
    assert report["determinism"].status is Status.NOT_APPLICABLE
    assert report["controls"].summary == "it returned no path"
    assert report["symmetries"].status is Status.NOTE
    assert {one.name for one in report.with_status(Status.PASS)} == {"outcome", "loading"}, report
    assert "It claims nothing of any answer" in str(report)
    assert report.to_dict()["claimed"] == 0
    assert "claims nothing" not in str(checked(Right, ["claims"]))


@pytest.mark.parametrize("kind", [Raising, Confident, Misled, Bounding])
def test_every_failure_shows_a_command(kind):
    """Every failure shows a command.

    It does so where its advice was given before, and where one question shows nothing.
    """
    report = checked(kind)
    failed_by = {
        result.name: [one for one in result.findings if one.status is Status.FAIL]
        for result in report
    }
    failures = [one for findings in failed_by.values() for one in findings]

    assert failures
    for finding in failures:
        assert finding.command.startswith("dubins-study "), finding
        assert re.search(r"solve .*--solver \S+ -- |check-solver \S+ --check", finding.command)
        assert f"$ {finding.command}\n" in str(report)
    assert len(re.findall(r"^ +\$ ", str(report), re.MULTILINE)) == len(failures)


def test_commands_ask_in_the_profile_of_the_check():
    report = check_solver(Confident, checks=["discs"], profile="accurate", isolated=False)
    commands = [finding.command for result in report for finding in result.findings]

    assert commands
    assert all(" --profile accurate " in command for command in commands)


@pytest.mark.parametrize(("kind", "width"), [(Raising, 40), (Lost, 64), (Lost, 100)])
def test_the_report_fits_the_terminal(kind, width):
    """The report fits the terminal.

    Tracebacks and commands are copied whole; a line goes on below its text.
    """
    path = re.escape(checked(kind, ["loading"]).solver)
    shown = re.sub(path, "my.py:Mine", report_text(checked(kind), width))
    whole = ("$", "File", "raise ", "NotImplementedError")  # commands and tracebacks
    lines = [one for one in shown.splitlines() if not one.lstrip().startswith(whole)]
    marked = ("pass  ", "note  ", "FAIL  ", "  –   ", "  ?   ", "      ", "passed: ", "FAILED: ")

    assert max(map(len, lines)) <= width
    assert all(one.startswith((*marked, "my.py:Mine")) or one == "" for one in lines[:-3]), shown


@pytest.mark.parametrize(
    ("kind", "least", "most"), [(Modest, 40, 50), (Everything, 82, 90), (OneWord, 4, 40)]
)
def test_how_many_questions_are_asked(kind, least, most):
    """The number of questions is the documented one.

    It is 40 to 90 of a solver that answers `best`, by what else it does.
    """
    asked = sum(checked(kind, CHECKS).answers.values())

    assert least <= asked <= most


def test_only_what_a_solver_takes_is_asked():
    """A solver is asked only what it takes.

    Checks of other scenarios do not apply, and say why; the rest ask what it takes.
    """
    report = checked(OfPoses, CHECKS)

    assert report.passed, report
    assert sum(report.answers.values()) == report.answers["optimal"] == len(OF_KIND["pose"]) + 9
    assert report["poses"].summary == f"{len(OF_KIND['pose'])} questions"
    assert report["controls"].summary == "the solver takes only final heading"
    assert report["routes"].summary == "the solver takes only final heading"
    assert report["limits"].status is report["determinism"].status is Status.PASS


@pytest.mark.parametrize(
    ("kind", "routes", "tours"), [(OfRoutes, 6, 0), (OfTours, 6, 3), (Right, 9, 6)]
)
def test_routes_and_tours_are_asked_of_solvers_that_take_them(kind, routes, tours):
    """Routes and tours are asked where they are taken.

    Each has its order, end and headings only where those are taken.
    """
    report = checked(kind, ["routes", "tours"])

    assert report.passed, report
    assert sum(report.answers.values()) == report.answers["optimal"] == routes + tours
    assert report["routes"].summary == f"{routes} questions"
    assert report["tours"].status is (Status.PASS if tours else Status.NOT_APPLICABLE)


def test_headings_that_are_not_looked_at_are_named():
    """Ignored headings are named.

    One at a point is a miss; a start that is free is a false claim of the shortest path.
    """
    report = checked(Fixed, ["routes", "tours"])

    for check in ("routes", "tours"):
        assert report[check].status is Status.FAIL
        assert "with another heading than is given there" in text(report, check)
        assert "it claims optimal, but its path" in text(report, check)


def test_a_longer_tour_is_told_its_order():
    """A longer tour is told its order.

    The shortest tour's stands beside it: what is to be mended is the order, or the headings.
    """
    message = text(checked(InOrder, ["tours"]), "tours")

    assert re.search(r"% longer .*; its order is 0 1 2 3, the shortest one's (?!0 1 2 3)", message)


def test_a_solver_has_to_take_an_end():
    report = checked(OfNothing, ["loading"])

    assert report["loading"].status is Status.FAIL
    assert "takes is ['via points'], and every scenario needs more" in text(report, "loading")


def test_no_route_and_no_pose_is_without_a_path():
    """Every route and every pose has a path.

    Its denial is a false claim; a path that is not found is a note. Both name the shortest.
    """
    denied, unfound = (checked(kind, ["poses", "routes"]) for kind in (Denying, Silent))
    for check, word in (("poses", "RSL"), ("routes", "RSR RS")):
        assert denied[check].status is Status.FAIL
        assert f"that no path exists; there is one, {word}, of length" in text(denied, check)
        assert unfound[check].status is Status.NOTE
        assert f"it finds no path (claim failed); there is one, {word}" in text(unfound, check)


def test_a_miss_within_a_tolerance_is_no_mix_up():
    report = checked(Nearly, ["poses", "routes"])

    for check in ("poses", "routes"):
        assert "tighten the tolerance of the points and headings" in text(report, check), report


def test_the_routes_of_the_kit_are_those_that_it_promises():
    """The kit's routes are those that it promises.

    They have two to five legs and three spacings: one in two orders, one in line, one to a
    heading.

    The search proves each in less than a second of work; a millionth is a hundredth of the gap that
    an answer may have.
    """
    spacings = [
        [math.dist(a, b) / route.radius for a, b in itertools.pairwise(route.points.tolist())]
        for route in OF_KIND["route"].values()
    ]
    laws = [
        any(all(low <= leg <= high for leg in legs) for legs in spacings)
        for low, high in ((4, 20), (2, 4), (0.5, 2))
    ]
    points = [sorted(route.points.tolist()) for route in OF_KIND["route"].values()]
    a, b, c, _ = OF_KIND["route"]["3 legs, the points in line"].points

    assert {route.legs for route in OF_KIND["route"].values()} == {2, 3, 4, 5}
    assert all(laws), spacings
    assert len(points) - 1 == len(set(map(str, points)))
    assert (b[0] - a[0]) * (c[1] - a[1]) == (b[1] - a[1]) * (c[0] - a[0])
    assert sum(route.final_heading is not None for route in OF_KIND["route"].values()) == 1
    for route in OF_KIND["route"].values():
        reference = reference_of(route, "best", replace(DEFAULT, search_s=1.0)).enclosure
        assert reference.high <= reference.low * (1 + 1e-6), route.label


def test_the_advice_for_a_disc_is_not_that_for_the_axis():
    report = checked(Lost, ["axis", "discs"])

    assert "no turn towards the target leads to it" in text(report, "discs")
    assert "no turn towards" not in text(report, "axis")


def test_a_solve_without_its_second_argument():
    assert "def solve(self, question, limit)" in text(checked(Brief, ["outcome"]), "outcome")
