"""All findings, in the order of the page: what to choose first, then what not to conclude."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from dubins_study.report.topics.findings.engine import (
    derivative_free_search,
    no_rank,
    presolve,
    slowest_engine,
)
from dubins_study.report.topics.findings.evidence import Evidence
from dubins_study.report.topics.findings.finding import Finding
from dubins_study.report.topics.findings.formulation import (
    coarse_transcription,
    fastest_formulation,
    near_circles,
    single_order,
    words_against_joint,
)
from dubins_study.report.topics.findings.guess import random_restarts, repeats, zero_start
from dubins_study.report.topics.findings.proof import (
    false_proof,
    infeasible_claims,
    price_of_proof,
)

FINDINGS: tuple[Callable[[Evidence], Finding | None], ...] = (
    fastest_formulation,
    words_against_joint,
    zero_start,
    slowest_engine,
    presolve,
    price_of_proof,
    false_proof,
    infeasible_claims,
    near_circles,
    no_rank,
    derivative_free_search,
    single_order,
    coarse_transcription,
    random_restarts,
    repeats,
)


# Those that say what not to do: they stand with what not to conclude.
WARNINGS = (infeasible_claims, no_rank, coarse_transcription)
ADVICE = tuple(find for find in FINDINGS if find not in WARNINGS)


def findings(
    evidence: Evidence, finders: Sequence[Callable[[Evidence], Finding | None]] = FINDINGS
) -> list[Finding]:
    """The findings that the rows carry."""
    return [finding for find in finders if (finding := find(evidence)) is not None]
