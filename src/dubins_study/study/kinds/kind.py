"""Facts and functions that a kind of question states."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from dubins_study.study.arrays import FloatArray
from dubins_study.study.check.enclosure import Enclosure
from dubins_study.study.check.extremal import Extremal
from dubins_study.study.check.verdict import Seen
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Certificate, Judgement
from dubins_study.study.scenario import OPTIONAL, Scenario
from dubins_study.study.tolerances import Tolerances
from dubins_study.study.words import Claim, Verdict


class Reference(NamedTuple):
    """Reference that an answer is compared with.

    For a route the enclosure's one part is an interval that holds the shortest length. For one leg
    its parts hold the shortest lengths for all data within delta.
    """

    enclosure: Enclosure
    path: Path | None  # the shortest that is known; None where a branch has none
    at: tuple[float, ...]  # the arc lengths at which its legs end, but for the last


class Exact(NamedTuple):
    """Shortest path with a proven interval.

    The interval holds the shortest length (length unit).
    """

    path: Path | None  # None where a branch has none
    low: float
    high: float

    @classmethod
    def known(cls, path: Path | None) -> Exact:
        """A shortest path of known length, by formula."""
        length = math.inf
        if path is not None:
            length = path.length
        return cls(path, length, length)


class Arrived(NamedTuple):
    """A path that arrives, ready for its verdict."""

    path: Path
    branch: str
    seen: Seen
    word: str


class Found(NamedTuple):
    """Verdict on an arriving path, with judgement columns."""

    verdict: Verdict
    columns: dict[str, Any]


class Costates(NamedTuple):
    """Pontryagin's conditions of a path, and its cut margin.

    The margin is in rad. A field is None where it is unknown.
    """

    extremal: Extremal | None = None
    cut: float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Asked:
    """How a question of a kind is recognised."""

    name: str
    title: str  # name of a scenario of the kind in messages
    task: str = ""  # subject of the kit's check of the kind; empty: it has no such check
    fields: Mapping[str, bool]  # optional fields of a scenario: whether they are given
    branches: tuple[str, ...]
    examples: Mapping[str, Scenario] = field(default_factory=dict)  # the kit's questions, by name

    def matches(self, scenario: Scenario) -> bool:
        """Whether a scenario is of this kind.

        The scenario has to give, or leave out, each optional field as `fields` says.
        """
        return self.fits(scenario.given)

    def fits(self, given: tuple[bool, ...]) -> bool:
        """Whether flags of given fields match this kind.

        The flags say which of the fields of `OPTIONAL` are given (`Scenario.given`).
        """
        has = dict(zip(OPTIONAL, given, strict=True))
        return all(has[name] == needed for name, needed in self.fields.items())


@dataclass(frozen=True, eq=False, kw_only=True)
class Pathless(Asked):
    """A kind whose answer is a point.

    There is no path, and the kind has a judge of its own.

    Args:
        judge: judgement and certificate of a question's point; from the scenario, the point (None
            without an answer), the claim and the tolerance.
    """

    judge: Callable[[Scenario, FloatArray | None, Claim, float], tuple[Judgement, Certificate]]


@dataclass(frozen=True, eq=False, kw_only=True)
class Kind(Asked):
    """A kind whose answer is a path.

    Args:
        exact: the shortest path of a branch, searched for during about a limit (s).
        prepare: makes `exact` ready, which may take seconds once.
        exists: whether a branch has a path; by default every branch has one.
        reference: the reference that an answer of a branch is compared with.
        known: columns of a judgement that only scenario and branch decide, if there are any.
        words_of: the word of a path, of its legs where it has several; from the path, the arc
            lengths of its via points, and the radius.
        verdict: of a path that arrives.
        costates: Pontryagin's conditions and cut margin of a judged path; what is not computed by
            a time of `perf_counter` stays None.
        ties: the words that share the shortest length, if more than one may.
        by_interval: whether a proven interval alone proves a shortest path; else the path has to be
            an extremal too.
        searched: whether a reference is searched for, which takes longer than a formula.
        need_of_rows: the need that a solver which answers whole frames must take to be given
            these rows; empty where rows are asked one by one.
        drawing: how the report draws a path: with its `circles`, or as a `route`.
    """

    exact: Callable[[Scenario, str, float], Exact]
    prepare: Callable[[], None] = lambda: None
    exists: Callable[[Scenario, str], bool] = lambda scenario, branch: True
    reference: Callable[[Scenario, str, Tolerances], Reference]
    known: Callable[[Scenario, str], dict[str, Any]] = lambda scenario, branch: {}
    words_of: Callable[[Path, Sequence[float], float], str]
    verdict: Callable[[Scenario, Arrived, Tolerances], Found]
    costates: Callable[[Scenario, Path, Judgement, float], Costates]
    ties: Callable[[Scenario, str], tuple[str, ...]] = lambda scenario, branch: ()
    by_interval: bool = True
    searched: bool = False
    need_of_rows: str = ""
    drawing: str = "route"
