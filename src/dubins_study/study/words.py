"""The words of the study: letters, branches, formulations, and what may be said of an answer."""

from __future__ import annotations

from enum import StrEnum

# the rate of each letter: curvature times radius
TURN = {"L": 1.0, "S": 0.0, "R": -1.0}
BRANCHES = ("best", "LS", "RS", "LR", "RL")

# The mathematical problems that are handed to engines, in the order of tables. The joint NLP is the
# paper's model (4.12) with its turns in one order, in the other, or the better of both.
FORMULATIONS = (
    "closed form",
    "one NLP a word",
    "joint NLP, LRS",
    "joint NLP, RLS",
    "joint NLP, both orders",
    "turn rates",
    "Radau collocation",
    "multiple shooting",
    "Pontryagin's system",
    "grid of headings",
    "disjunction",
    "penalty",
)


class Outcome(StrEnum):
    """The way in which the call of a solver ended."""

    RETURNED = "returned"
    TIMEOUT = "timeout"
    CRASHED = "crashed"
    RAISED = "raised"
    OUT_OF_MEMORY = "out_of_memory"
    UNSUPPORTED = "unsupported"
    UNAVAILABLE = "unavailable"


class Claim(StrEnum):
    """What a solver says of its answer, strongest first."""

    OPTIMAL = "optimal"
    LOCAL = "local"
    FEASIBLE = "feasible"
    INFEASIBLE = "infeasible"
    LIMIT = "limit"
    FAILED = "failed"
    NONE = "none"


class Verdict(StrEnum):
    """What the check finds."""

    OPTIMAL = "optimal"
    LONGER = "longer"
    MISSES = "misses"
    NONE = "none"
    NONE_EXISTS = "none exists"


class Proof(StrEnum):
    """How far the proof of an answer goes, furthest first.

    * proved: the length is within tolerance of a proven interval around the shortest lengths of
      the targets within delta, and the path is an extremal, for `best` also clear of its cut (of
      LR and RL the interval alone decides); or there is provably no path, and none was returned.
      Of a word's few paths the interval holds the shortest, so that its cut says nothing.
    * bounded: the solver's own lower bound is within the tolerance, and contradicts nothing.
    * extremal: an arriving path that satisfies Pontryagin's conditions.
    * none: none of these.
    """

    PROVED = "proved"
    BOUNDED = "bounded"
    EXTREMAL = "extremal"
    NONE = "none"
