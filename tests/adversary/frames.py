"""Whole frames beside single scenarios: both have to say the same."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from dubins_study.solvers.analytic import Analytic
from dubins_study.solvers.protocol import Question
from dubins_study.study.check.certificate import certify
from dubins_study.study.check.certificate_frame import PROOFS, FrameCertificate, certify_frame
from dubins_study.study.check.two_arcs import PATH_WORDS
from dubins_study.study.check.verdict import judge
from dubins_study.study.check.verdict_frame import (
    NO_WORD,
    REGIONS,
    VERDICTS,
    FrameJudgement,
    judge_frame,
)
from dubins_study.study.closed_form.kernel import shortest_rows
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.path import Paths
from dubins_study.study.rows.schema import Certificate, Judgement
from dubins_study.study.scenario import NUMBERS, Scenario
from dubins_study.study.words import BRANCHES, Verdict
from tests.adversary.checks import ulp
from tests.adversary.generators import Answer
from tests.adversary.table import Table, paste, paste_path
from tests.cases import scenario_frame

Cases = Sequence[tuple[str, Scenario]]
Hulls = dict[str, tuple[float, float]]  # least and greatest length (length unit) by branch


class Judged(NamedTuple):
    """An answer, its kind, and what the scalar check says of it."""

    kind: str
    answer: Answer
    judgement: Judgement
    certificate: Certificate


def closed_forms(table: Table, cases: Cases) -> None:
    """`shortest_rows` of every branch beside `shortest_path`."""
    frame = scenario_frame(scenario for _, scenario in cases)
    columns = [frame[name].to_numpy() for name in NUMBERS if name != "speed"]
    for branch in BRANCHES:
        rows = shortest_rows(*columns, branch=branch)
        for length, (kind, scenario) in zip(rows.length.tolist(), cases, strict=True):
            table.generator = kind
            line = f"shortest_rows of {paste(scenario, branch)}"
            path = shortest_path(scenario, branch)
            table.note("kernel existence", math.isnan(length) != (path is None), line)
            if path is not None and not math.isnan(length):
                apart = abs(length - path.total_length) / ulp(length, scenario.radius)
                table.note("kernel length", apart, line)


def judgements(table: Table, cases: Cases, sampled: Sequence[Hulls]) -> None:
    """The answers of `analytic`, frame and scalar, judged and certified.

    `sampled` are the least and the greatest of each case's sampled lengths.
    """
    frame = scenario_frame(scenario for _, scenario in cases)
    solver = Analytic()
    for branch in BRANCHES:
        solution = solver.solve_frame(frame.copy(), branch)
        rows = judge_frame(frame, solution.paths, solution.claim, branch)
        certified = certify_frame(frame, solution.paths, rows, branch, solution.lower_bound)
        for row, (kind, scenario) in enumerate(cases):
            table.generator = kind
            single = solver.solve(Question(scenario, branch), 1.0)
            judged = judge(scenario, single.path, single.claim, branch)
            certificate = certify(
                scenario, single.path, judged, branch, lower_bound=single.lower_bound
            )
            line = f"solve({paste(scenario, branch)})"
            wrong = judged.verdict not in (Verdict.OPTIMAL, Verdict.NONE_EXISTS)
            wrong |= judged.false_claim or certificate.false_bound
            table.note("analytic claim", wrong, f"{line}  # {judged.verdict}")
            if branch in sampled[row]:
                low, high = sampled[row][branch]
                found = certified.reference_low[row], certified.reference_high[row]
                off = max(found[0] - low, high - found[1], 0.0) / ulp(high, scenario.radius)
                text = f"{line}  # frame {found}, truth {low!r} {high!r}"
                table.note("frame interval holds truth", off, text)
            _same(table, rows, certified, row, (judged, certificate), scenario, line)


def wrong_answers(table: Table, answers: Iterable[Judged]) -> None:
    """Altered answers of at most two pieces beside what the scalar check says of them."""
    few = [one for one in answers if one.answer.path.length.size < 3]
    for branch in BRANCHES:
        some = [one for one in few if one.answer.branch == branch]
        if not some:
            continue
        frame = scenario_frame(one.answer.scenario for one in some)
        controls = np.zeros((2, 2, len(some)))
        for row, one in enumerate(some):
            path = one.answer.path
            controls[0, : path.curvature.size, row] = path.curvature
            controls[1, : path.length.size, row] = path.length
        paths = Paths(*controls)
        rows = judge_frame(frame, paths, branch=branch)
        certified = certify_frame(frame, paths, rows, branch)
        for row, one in enumerate(some):
            table.generator = one.kind
            scenario = one.answer.scenario
            line = paste_path(scenario, branch, one.answer.path)
            _same(table, rows, certified, row, one[2:], scenario, line)


def _same(
    table: Table,
    rows: FrameJudgement,
    certified: FrameCertificate,
    row: int,
    scalar: tuple[Judgement, Certificate],
    scenario: Scenario,
    line: str,
) -> None:
    """What a frame says of one row beside what the scalar check says."""
    judged, certificate = scalar
    word = int(rows.word[row])
    measured = {name: values[row] for name, values in certified.columns().items()}
    pairs = {
        "verdict": (VERDICTS[rows.verdict[row]], judged.verdict),
        "region": (REGIONS[rows.region[row]], judged.region),
        "word": (None if word == NO_WORD else PATH_WORDS[word], judged.word),
        "wrong_basin": (bool(rows.wrong_basin[row]), judged.wrong_basin),
        "proof": (PROOFS[certified.proof[row]], certificate.proof),
        "false_bound": (bool(certified.false_bound[row]), certificate.false_bound),
        "residual": (math.isnan(measured["pmp_residual"]), certificate.pmp_residual is None),
        "cut": (math.isnan(measured["cut_margin"]), certificate.cut_margin is None),
    }
    differ = [f"{name}: frame {a}, scalar {b}" for name, (a, b) in pairs.items() if a != b]
    table.note("frame judgement", bool(differ), f"{line}  # {', '.join(differ)}")
    if judged.gap is not None and judged.reference is not None and judged.length is not None:
        # an ulp of the reference counts for as much as the answer is longer
        reference = max(judged.reference, scenario.radius)
        scale = reference / ulp(judged.length, scenario.radius)
        scale /= max(1.0, judged.length / reference)
        gap = float(rows.gap[row])
        apart = math.inf if math.isnan(gap) else abs(gap - judged.gap) * scale
        table.note("frame gap", apart, f"{line}  # gap {gap} {judged.gap}")
    low, high = certificate.reference_low, certificate.reference_high
    least, most = float(certified.reference_low[row]), float(certified.reference_high[row])
    text = f"{line}  # frame {least!r} {most!r}, balls {low!r} {high!r}"
    missing = (low is None) != math.isnan(least) or (high is None) != math.isnan(most)
    table.note("frame interval", missing, text)
    if low is not None and high is not None and not missing:
        wider = (most - least - 64 * (high - low)) / max(high, scenario.radius)
        table.note("frame interval width", 1e12 * wider, text)
