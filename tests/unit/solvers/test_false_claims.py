"""The list of false claims, replayed by the engines.

The list is `tests/false_claims.toml`.
"""

import tomllib
import warnings
from importlib.metadata import version
from pathlib import Path

import pytest

from dubins_study.asking.attempt import Answer, attempt
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import load
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim, Verdict

FILE = Path(__file__).parents[2] / "false_claims.toml"
CLAIMS = tomllib.loads(FILE.read_text(encoding="utf-8"))["claims"]
KINDS = {
    "false bound": lambda answer: answer.false_bound,
    "false optimal": lambda answer: answer.false_claim and answer.claim is Claim.OPTIMAL,
    "denial": lambda answer: answer.claim is Claim.LOCALLY_INFEASIBLE,
    "false infeasible": lambda answer: answer.false_claim and answer.claim is Claim.INFEASIBLE,
}


def name(claim: dict) -> str:
    return f"{claim['solver']} {claim['kind']} {claim['target']}"


def installed(spec: str) -> bool:
    return load(spec).unavailable() is None


def ask(claim: dict, spec: str) -> Answer:
    scenario = Scenario(0, 0, 0, *claim["target"], 1)
    return attempt(load(spec), Question(scenario, claim.get("branch", "best")), 30.0)


REPLAYED = [claim for claim in CLAIMS if installed(claim["solver"])]


@pytest.mark.parametrize("claim", REPLAYED, ids=name)
def test_the_claim_is_still_false(claim):
    """The claim is still false.

    It was seen with one version; with another one a warning says what has changed.
    """
    answer = ask(claim, claim["solver"])
    ((package, seen),) = claim["seen_with"].items()

    if version(package) == seen:
        assert KINDS[claim["kind"]](answer), answer
    elif not KINDS[claim["kind"]](answer):
        warnings.warn(
            f"{name(claim)} was seen with {package} {seen} and is gone with {version(package)}: "
            f"claim {answer.claim}, verdict {answer.verdict}; strike it from {FILE.name}",
            stacklevel=1,
        )


@pytest.mark.parametrize("claim", [c for c in REPLAYED if installed(c["cured_by"])], ids=name)
def test_what_cures_it_is_right(claim):
    answer = ask(claim, claim["cured_by"])

    assert answer.verdict is Verdict.OPTIMAL, answer
    assert not answer.false_claim
    assert not answer.false_bound


def test_every_entry_can_be_replayed():
    """Every entry can be replayed.

    Its solvers exist, its kind is known, one version is named; SCIP's are replayed anywhere.
    """
    for claim in CLAIMS:
        assert set(claim) - {"branch"} == {
            *("solver", "target", "kind", "seen_with", "cured_by", "why")
        }
        assert claim["kind"] in KINDS
        assert len(claim["seen_with"]) == 1
        load(claim["solver"])
        load(claim["cured_by"])
    assert sum("pyscipopt" in claim["seen_with"] for claim in REPLAYED) >= 5
