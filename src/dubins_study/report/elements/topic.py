"""A topic of the report: a section of the page, and the attempts that it is about."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum, auto
from typing import NamedTuple

from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import Place, Section

BENCHMARK = "benchmark"  # the key of the experiment on which methods are compared


class General(Enum):
    """The attempts of a section that is not about a single experiment."""

    EVERY = auto()  # all attempts
    POOLED = auto()  # counted together: without studies of variants and of extreme questions
    COMPARED = auto()  # attempts at questions on which solvers are compared
    DECIDED = auto()  # those of benchmarks, else those compared, else all


class Topic(NamedTuple):
    """One section of the page."""

    title: str  # its name in progress reports
    write: Callable[[Results], Section | None]  # None if there is nothing to show
    # its attempts: a general kind, or the key that experiments give as `section = "..."` in their
    # TOML file
    about: General | str
    enters: tuple[General, ...] = ()  # the general kinds that include those experiments too
    # That of a study stands in the details where there is a benchmark, which the page is about
    # then, and else on the front.
    place: Place = Place.DETAILS
