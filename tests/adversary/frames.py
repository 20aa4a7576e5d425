"""Compare whole frames with single scenarios.

Both have to say the same.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from dubins_study.solvers.analytic import Analytic
from dubins_study.solvers.protocol import Question
from dubins_study.study.closed_form.shortest import REGIONS, shortest_path
from dubins_study.study.judging.certify import certify
from dubins_study.study.judging.judge import judge
from dubins_study.study.judging.verdict_frame import (
    LEG_WORDS,
    NO_WORD,
    VERDICTS,
    FrameJudgement,
    judge_frame,
)
from dubins_study.study.path import CLAIMS, Path, Paths
from dubins_study.study.rows.schema import Certificate, Judgement
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import BRANCHES, Claim, Verdict
from tests.adversary.checks import ulp
from tests.adversary.table import Table, paste, paste_path
from tests.cases import scenario_frame

_RIGHT = (Verdict.OPTIMAL, Verdict.NONE_EXISTS)


class Judged(NamedTuple):
    """An answer and the scalar check's judgement.

    `truth` are the least and the greatest of the sampled lengths (length unit), if they are known.
    """

    kind: str
    scenario: Scenario
    branch: str
    path: Path | None
    claim: Claim
    bound: float | None
    judgement: Judgement
    certificate: Certificate
    truth: tuple[float, float] | None = None


def judged(
    kind: str,
    scenario: Scenario,
    branch: str,
    path: Path | None,
    claim: Claim = Claim.NONE,
    bound: float | None = None,
    truth: tuple[float, float] | None = None,
) -> Judged:
    """An answer, judged and certified alone."""
    judgement = judge(scenario, path, claim, branch)
    certificate = certify(scenario, path, judgement, branch, lower_bound=bound)
    return Judged(kind, scenario, branch, path, claim, bound, judgement, certificate, truth)


def analytic(
    table: Table, scenario: Scenario, sampled: dict[str, tuple[float, float]]
) -> list[Judged]:
    """Answers of `analytic` to one scenario.

    They are judged and certified.
    """
    answers = []
    for branch in BRANCHES:
        solution = Analytic().solve(Question(scenario, branch), 1.0)
        asked = (
            table.generator,
            scenario,
            branch,
            solution.path,
            solution.claim,
            solution.lower_bound,
        )
        one = judged(*asked, sampled.get(branch))
        wrong = one.judgement.verdict not in _RIGHT
        wrong |= one.judgement.false_claim or one.certificate.false_bound
        table.note("analytic claim", wrong, f"solve({paste(scenario, branch)})")
        answers.append(one)
    return answers


def closed_forms(table: Table, cases: Sequence[tuple[str, Scenario]]) -> None:
    """Compare judged frames of `analytic` with the closed form.

    The closed form is the scalar one.
    """
    frame = scenario_frame(scenario for _, scenario in cases)
    for branch in BRANCHES:
        solution = Analytic().solve_frame(frame.copy(), branch)
        rows = judge_frame(frame, solution.paths, solution.claim, branch)
        assert solution.lower_bound is not None
        for row, (length, (kind, scenario)) in enumerate(
            zip(solution.lower_bound.tolist(), cases, strict=True)
        ):
            table.generator = kind
            line = f"solve_frame of {paste(scenario, branch)}"
            path = shortest_path(scenario, branch)
            table.note("kernel existence", math.isnan(length) != (path is None), line)
            if path is not None and not math.isnan(length):
                apart = abs(length - path.length) / ulp(length, scenario.radius)
                table.note("kernel length", apart, line)
            wrong = VERDICTS[rows.verdict[row]] not in _RIGHT or rows.false_claim[row]
            table.note("analytic claim", wrong, line)


def checks_of_frames(table: Table, answers: Sequence[Judged]) -> None:
    """Check a frame of answers, two pieces at most.

    Each row is compared with the scalar check.
    """
    few = [one for one in answers if one.path is None or one.path.lengths.size < 3]
    for branch in BRANCHES:
        some = [one for one in few if one.branch == branch]
        frame = scenario_frame(one.scenario for one in some)
        controls = np.zeros((2, 2, len(some)))
        for row, path in enumerate(one.path for one in some):
            if path is not None:
                controls[0, : path.curvatures.size, row] = path.curvatures
                controls[1, : path.lengths.size, row] = path.lengths
        paths = Paths(*controls, np.array([one.path is not None for one in some], np.bool_))
        claims = np.array([CLAIMS.index(one.claim) for one in some], np.intp)
        rows = judge_frame(frame, paths, claims, branch)
        for row, one in enumerate(some):
            table.generator = one.kind
            _same(table, rows, row, one)


def _same(table: Table, rows: FrameJudgement, row: int, one: Judged) -> None:
    """Compare one row of a frame with scalar checks."""
    scenario = one.scenario
    judgement = one.judgement
    line = paste(scenario, one.branch)
    if one.path is not None:
        line = paste_path(scenario, one.branch, one.path)
    word = int(rows.word[row])
    pairs = {
        "verdict": (VERDICTS[rows.verdict[row]], judgement.verdict),
        "region": (REGIONS[rows.region[row]], judgement.region),
        "word": (None if word == NO_WORD else LEG_WORDS[word], judgement.word),
        "false_claim": (bool(rows.false_claim[row]), judgement.false_claim),
        "wrong_basin": (bool(rows.wrong_basin[row]), judgement.wrong_basin),
    }
    differ = [f"{name}: frame {a}, scalar {b}" for name, (a, b) in pairs.items() if a != b]
    table.note("frame judgement", bool(differ), f"{line}  # {', '.join(differ)}")
    # numbers are compared in units of what is added up: coordinates, radius and length
    size = scenario.extent + scenario.radius + (judgement.length or 0.0)
    units = {"length": size, "miss": size, "travel_time": size / scenario.speed}
    units |= {
        "margin": size / scenario.radius,
        "curvature_excess": 1 + (judgement.curvature_excess or 0),
    }
    pairs = {
        name: (getattr(rows, name)[row], getattr(judgement, name), units[name]) for name in units
    }
    table.note("frame numbers", 1e14 * _apart(pairs), f"{line}  # {pairs}")
    if (
        judgement.gap is not None
        and judgement.reference is not None
        and judgement.length is not None
    ):
        # an ulp of the reference counts for as much as the answer is longer
        reference = max(judgement.reference, scenario.radius)
        scale = reference / ulp(judgement.length, scenario.radius)
        scale /= max(1.0, judgement.length / reference)
        gap = float(rows.gap[row])
        apart = math.inf if math.isnan(gap) else abs(gap - judgement.gap) * scale
        table.note("frame gap", apart, f"{line}  # gap {gap} {judgement.gap}")


def _apart(pairs: dict[str, tuple[float, float | None, float]]) -> float:
    """The largest difference of two values.

    In its unit, or as a share of the number. Infinite if one of the two is missing.
    """
    worst = 0.0
    for frame, scalar, unit in pairs.values():
        if scalar is None or math.isnan(frame):
            if scalar is not None or not math.isnan(frame):
                worst = math.inf
        elif frame != scalar:
            worst = max(worst, abs(frame - scalar) / max(unit, abs(scalar)))
    return worst
