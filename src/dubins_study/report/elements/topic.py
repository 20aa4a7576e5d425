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
    """One section of the page.

    Args:
        title: its name in progress reports.
        write: attempts -> the section; None if there is nothing to show.
        about: its attempts: a general kind, or the key that experiments give as `section = "..."`
            in their TOML file.
        enters: the general kinds that include those experiments too.
        place: where its section stands. That of a study stands in the details where there is a
            benchmark, which the page is about then, and else on the front.
    """

    title: str
    write: Callable[[Results], Section | None]
    about: General | str
    enters: tuple[General, ...] = ()
    place: Place = Place.DETAILS
