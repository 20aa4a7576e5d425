"""Words of the study, as constants and types.

They name letters, branches, formulations, claims and verdicts.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from types import MappingProxyType
from typing import NamedTuple

# the rate of each letter: curvature times radius
TURN = {"L": 1.0, "S": 0.0, "R": -1.0}
BRANCHES = ("best", "LS", "RS", "LR", "RL")  # of one leg with a free final heading
POSE_BRANCHES = ("best", "LSL", "RSR", "LSR", "RSL", "RLR", "LRL")  # of one leg that has one given
# The branch without a path: the convex problem that was frozen from a route (study.convex). The
# scenario's label names it.
FROZEN = "frozen"

# Needs of scenarios, which solvers say that they take.
VIA_POINTS = "via points"
FREE_FINAL_HEADING = "free final heading"
FINAL_HEADING = "final heading"
HEADINGS_AT_STOPS = "headings at stops"
FREE_START = "free start heading"
FREE_ORDER = "free order"
CLOSED = "closed"
# the field of a scenario that causes the need, and whether it has to be given (or left out)
NEEDS = {
    VIA_POINTS: ("via", True),
    FREE_FINAL_HEADING: ("final_heading", False),
    FINAL_HEADING: ("final_heading", True),
    HEADINGS_AT_STOPS: ("via_heading", True),
    FREE_START: ("free_start", True),
    FREE_ORDER: ("order", True),
    CLOSED: ("closed", True),
}
# what most solvers of routes take
IN_ORDER = frozenset({VIA_POINTS, FREE_FINAL_HEADING, FINAL_HEADING})

# Kinds of engines, each with its own formulations. They are headings in the table of both.
EXACT = "exact"
NLP = "local NLP"
PROVEN = "global, with proof"
SAMPLING = "stochastic or direct search"
DERIVATIVE_FREE = "derivative-free, local"
ROOTS = "roots"
QP = "QP and MILP"
MILP = "MILP"
CONSTRAINTS = "constraint programming"
ROUTING = "routing library"

# Engines that share the code of another one. Both count as one engine in general statements. Bonmin
# solves its nodes by Ipopt, and has one node without integers.
SAME_CODE = MappingProxyType({"Bonmin": "Ipopt", "NLopt SLSQP": "SLSQP", "Uno filterSQP": "Uno"})


class Formulation(NamedTuple):
    """A mathematical problem handed to engines."""

    name: str  # the column `formulation` of rows
    short: str  # its name beside an engine's in figures
    specs: Mapping[str, str]  # by kind of engine: the spec that asks for it; `{}` is the engine
    # by kind of engine: why none of them can read it, if the reason is unusual
    reasons: Mapping[str, str] = MappingProxyType({})
    knows: str = ""  # known of the answer: the formula, the words, or the shape of its pieces
    several: bool = False  # `bearing` tries several guesses a word, of one leg with a free heading


# Knowledge in initial guesses, by the column `guess`. `one` is drawn toward the target, `words` has
# a guess for each word, `blind` knows nothing of the answer's shape. There are ten random guesses.
GUESSES = MappingProxyType(
    {"one": "one", "bearing": "one", "words": "words", "given": "warm", "warm": "warm"}
    | {"straight": "blind", "zero": "blind", "random": "several blind"}
)
SEVERAL = "several"  # guesses a word

_KINDS = (NLP, PROVEN, SAMPLING, DERIVATIVE_FREE, ROOTS, QP, MILP, CONSTRAINTS, ROUTING)
_FORMULA = "a formula, which needs no engine"
_SQUARE = "a square system of equations: there is nothing to minimise"
_INTEGERS = "has integer variables"
_KINK = "has a kink wherever a path arrives: made for engines without derivatives"
_SIX_WORDS = "the shortest of six words: a function that is called, no expression"
_CORNERS = "begins with every corner of the box, of which a route has too many"
_CIRCUIT = "a circuit that leaves nodes out: a constraint of its engine's own"
_VEHICLE = "a vehicle's visits: a model of its library's own"
_PROGRAMS = "dynamic programs and exchanges, which need no engine"
_EQUATIONS = "the same as the joint NLP, with equations that these engines take as they are"

# In the order of tables. The joint NLP is the paper's model (4.12) with its turns in one order, in
# the other, or the better of both.
FORMULATION_LIST = (
    Formulation(
        name="closed form",
        short="closed form",
        specs={EXACT: "analytic"},
        reasons=dict.fromkeys(_KINDS, _FORMULA),
        knows="formula",
    ),
    Formulation(
        name="one NLP a word",
        short="word NLPs",
        specs={NLP: "nlp[engine={}]", PROVEN: "global-nlp[engine={},model=words]"},
        knows="words",
        several=True,
    ),
    Formulation(
        name="joint NLP, LRS",
        short="joint LRS",
        specs={
            NLP: "nlp[engine={},model=joint,order=LRS]",
            PROVEN: "global-nlp[engine={},order=LRS]",
        },
        knows="shape",
    ),
    Formulation(
        name="joint NLP, RLS",
        short="joint RLS",
        specs={
            NLP: "nlp[engine={},model=joint,order=RLS]",
            PROVEN: "global-nlp[engine={},order=RLS]",
        },
        knows="shape",
    ),
    Formulation(
        name="joint NLP, both orders",
        short="joint, both orders",
        specs={NLP: "nlp[engine={},model=joint]", PROVEN: "global-nlp[engine={}]"},
        knows="shape",
    ),
    Formulation(
        name="turn rates",
        short="turn rates",
        specs={NLP: "turn-rates[engine={}]", QP: "turn-rate-qp[engine={}]"},
        several=True,
    ),
    Formulation(
        name="Radau collocation",
        short="collocation",
        specs={NLP: "collocation[engine={}]"},
        several=True,
    ),
    Formulation(
        name="multiple shooting",
        short="multiple shooting",
        specs={NLP: "multiple-shooting[engine={}]"},
        several=True,
    ),
    Formulation(
        name="Pontryagin's system",
        short="Pontryagin",
        specs={ROOTS: "shooting[root={}]"},
        reasons={NLP: _SQUARE, PROVEN: _SQUARE},
        knows="words",
        several=True,
    ),
    Formulation(
        name="grid of headings",
        short="heading grid",
        specs={
            EXACT: "heading-grid",
            PROVEN: "heading-milp[engine={}]",
            QP: "heading-milp[engine={}]",
        },
        reasons={NLP: _INTEGERS, QP: _INTEGERS},
        knows="formula",  # of a leg between two headings
    ),
    Formulation(
        name="disjunction",
        short="disjunction",
        specs={PROVEN: "disjunctive[engine={}]"},
        reasons={NLP: _INTEGERS},
        knows="words",
    ),
    Formulation(
        name="penalty",
        short="penalty",
        specs=dict.fromkeys((SAMPLING, DERIVATIVE_FREE), "penalty[engine={}]"),
        reasons={NLP: _KINK, PROVEN: _EQUATIONS},
        knows="shape",
    ),
    # of routes, and of one leg too
    Formulation(
        name="joint NLP, LRSLR a leg",
        short="joint LRSLR",
        specs={NLP: "route-nlp[engine={}]"},
        knows="shape",
        several=True,
    ),
    Formulation(
        name="headings",
        short="headings",
        specs=dict.fromkeys((NLP, SAMPLING, DERIVATIVE_FREE), "headings[engine={}]"),
        reasons={NLP: _SIX_WORDS, PROVEN: _SIX_WORDS, SAMPLING: _CORNERS},
        knows="formula",  # of a leg between two headings
    ),
    # of tours
    Formulation(
        name="tour MILP",
        short="tour MILP",
        specs=dict.fromkeys((PROVEN, QP, MILP), "tour-milp[engine={}]"),
        reasons=dict.fromkeys((NLP, PROVEN, QP), _INTEGERS),
        knows="formula",
    ),
    Formulation(
        name="tour circuit",
        short="tour circuit",
        specs={CONSTRAINTS: "tour-circuit"},
        reasons=dict.fromkeys((NLP, PROVEN, QP, MILP), _CIRCUIT),
        knows="formula",
    ),
    Formulation(
        name="tour routing",
        short="tour routing",
        specs={ROUTING: "tour-routing"},
        reasons=dict.fromkeys((NLP, PROVEN, QP, MILP), _VEHICLE),
        knows="formula",
    ),
    Formulation(
        name="order then headings",
        short="order, then headings",
        specs={EXACT: "tour-order"},
        reasons=dict.fromkeys(_KINDS, _PROGRAMS),
        knows="formula",
    ),
)
FORMULATIONS = tuple(formulation.name for formulation in FORMULATION_LIST)
BY_NAME = {formulation.name: formulation for formulation in FORMULATION_LIST}


class Order(StrEnum):
    """Order in which via points are passed."""

    GIVEN = "given"
    FREE = "free"

    def __repr__(self) -> str:
        return repr(str(self))  # in a scenario's repr it then reads back


class Outcome(StrEnum):
    """How the call of a solver ended."""

    RETURNED = "returned"
    TIMEOUT = "timeout"
    CRASHED = "crashed"
    RAISED = "raised"
    OUT_OF_MEMORY = "out_of_memory"
    UNSUPPORTED = "unsupported"
    # in a `rising` experiment the solver failed on all shorter routes; in a file of answers there
    # is none for this question
    NOT_ASKED = "not_asked"
    UNAVAILABLE = "unavailable"


class Claim(StrEnum):
    """A solver's claim about its answer, strongest first."""

    OPTIMAL = "optimal"
    LOCAL = "local"
    FEASIBLE = "feasible"
    INFEASIBLE = "infeasible"
    LOCALLY_INFEASIBLE = "locally infeasible"  # no path near the engine's last point
    LIMIT = "limit"
    FAILED = "failed"
    NONE = "none"


# claims that there is no path: proven, or the end of a local search
DENIALS = (Claim.INFEASIBLE, Claim.LOCALLY_INFEASIBLE)


class Verdict(StrEnum):
    """Finding of the check about an answer."""

    OPTIMAL = "optimal"
    LONGER = "longer"
    MISSES = "misses"
    NONE = "none"
    NONE_EXISTS = "none exists"
    UNDECIDED = "undecided"  # the proven interval of a route is too wide to decide


class Proof(StrEnum):
    """How far an answer's proof goes, furthest first.

    * proved: the length is within tolerance of a proven interval around the shortest lengths of
      the targets within delta, and the path is an extremal, for `best` also clear of its cut. A
      single word has few paths and the interval holds the shortest, so the cut adds nothing. For
      LR and RL, for a route, and for a leg with a final heading the interval alone decides. An
      answer without a path is proved if provably none exists.
    * bounded: the solver's own lower bound is within the tolerance, and contradicts nothing.
    * extremal: an arriving path that satisfies Pontryagin's conditions.
    * none: none of these.
    """

    PROVED = "proved"
    BOUNDED = "bounded"
    EXTREMAL = "extremal"
    NONE = "none"


def short_word(word: str, most: int = 60) -> str:
    """Word shortened to `most` characters.

    A longer word keeps its beginning, with the number of its legs or letters.
    """
    if len(word) <= most:
        return word
    # cut between two legs, if the beginning has several
    beginning = word[:most].rpartition(" ")[0] or word[:most]
    legs = len(word.split(" "))
    count = f"{len(word)} letters"
    if legs > 1:
        count = f"{legs} legs"
    return f"{beginning} ... ({count})"
