"""The sections of the report, in page order.

This module also selects the attempts that each section shows.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from importlib import import_module
from itertools import chain

from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import BENCHMARK, General, Place, Section, Table, Topic
from dubins_study.report.elements.formats import slug
from dubins_study.report.elements.looks import labels_of

# Modules of `report` with their topics, in the order of the page.
_MODULES = (
    # the front: first the problem, then the main results
    "page.explorer",
    "topics.belief",
    "topics.routes",
    "topics.findings",
    "topics.decision",
    # the comparison in detail
    "topics.caution",
    "topics.summary",
    "topics.matrix",
    "topics.success",
    "topics.existence",
    "topics.certificates",
    "topics.comparison",
    "topics.cost",
    "topics.time",
    # the paper
    "topics.paper",
    "topics.audit_tables",
    "topics.paper_figures",
    # studies of one question each
    "topics.radius",
    "topics.convergence",
    "topics.searches",
    "topics.plane",
    "topics.basins",
    "topics.bias",
    "topics.convex",
    "topics.proofs",
    "topics.tours",
    "topics.ladder",
    "topics.failures",
    # single attempts, solvers and runs
    "topics.single_attempts",
    "topics.appendix",
)
_VALUES = chain.from_iterable(
    vars(import_module(f"dubins_study.report.{name}")).values() for name in _MODULES
)
TOPICS = tuple(value for value in _VALUES if isinstance(value, Topic))
KEYS = tuple(dict.fromkeys(topic.about for topic in TOPICS if isinstance(topic.about, str)))


def sections_of(topic: Topic, results: Results) -> Iterator[Section]:
    """Write the topic's sections.

    A study, whose `about` is an experiment's key, yields one section per experiment with this key.
    If there are several, each has its experiment's name. Other topics yield one section about all
    their attempts. A topic without rows yields none.
    """
    selections = _selections(topic, results)
    for name, selection in selections.items():
        section = topic.write(selection)
        if section is None:
            continue
        if len(selections) > 1:
            section = _named_after(section, name)
        yield _with_labels(replace(section, place=_place(topic, results)), results)


def _with_labels(section: Section, results: Results) -> Section:
    """The section whose tables know the solvers' short names."""
    labels = labels_of(results)
    blocks = list(section.blocks)
    for place, block in enumerate(blocks):
        if isinstance(block, Table):
            blocks[place] = replace(block, labels=labels)
    return replace(section, blocks=tuple(blocks))


def _place(topic: Topic, results: Results) -> Place:
    """The topic's place on the page.

    It is the topic's own, except on a page without a benchmark: there a study moves from the
    details to the front.
    """
    study = isinstance(topic.about, str) and topic.place is Place.DETAILS
    alone = all(run.section != BENCHMARK for run in results.folders)
    if study and alone:
        return Place.FRONT
    return topic.place


def _selections(topic: Topic, results: Results) -> dict[str, Results]:
    """The attempts of each section: experiment -> results.

    The key is empty for a section that is not about a single experiment.
    """
    # reversed: if folders share a name, the first folder's key stays
    keys = {run.name: run.section for run in reversed(results.folders)}
    if isinstance(topic.about, str):
        about = [run.name for run in results.folders if keys[run.name] == topic.about]
        return {name: results.only({name}) for name in about}
    names = _of_kinds(keys)[topic.about]
    # `results` itself, where nothing is left out: what was computed of it is kept
    if names == set(keys):
        return {"": results}
    if names:
        return {"": results.only(names)}
    return {}


def _of_kinds(keys: Mapping[str, str | None]) -> dict[General, set[str]]:
    """The names of the experiments of each general kind.

    `keys` maps each experiment to the key `section` of its file, or None. A study is an experiment
    whose key has a topic of its own. It counts in a general kind only if that topic lists the kind
    in `enters`.
    """
    studies = {topic.about for topic in TOPICS}
    admitted = {kind: {topic.about for topic in TOPICS if kind in topic.enters} for kind in General}

    def entering(kind: General) -> set[str]:
        # all experiments but studies, and those studies whose topic enters this kind
        return {name for name, key in keys.items() if key not in studies or key in admitted[kind]}

    every = set(keys)
    suites: set[str] = set()
    with_findings: set[str] = set()
    if BENCHMARK in keys.values():
        of_suites = {BENCHMARK, *admitted[General.BENCHMARKED]}
        suites = {name for name, key in keys.items() if key in of_suites}
        with_findings = suites | {
            name for name, key in keys.items() if key in admitted[General.FOUND]
        }
    return {
        General.EVERY: every,
        General.BENCHMARKED: suites,
        General.FOUND: with_findings,
        General.COMPARED: entering(General.COMPARED),
        # If nothing enters, the next set that is not empty is taken: a page of studies only has
        # these sections too.
        General.POOLED: entering(General.POOLED) or suites or every,
        General.DECIDED: suites or entering(General.COMPARED) or every,
    }


def _named_after(section: Section, experiment: str) -> Section:
    """The section with the experiment in all its names.

    These are its title, its anchor and the names of its files.
    """
    end = slug(experiment)
    blocks = tuple(replace(block, name=f"{block.name}-{end}") for block in section.blocks)
    title = f"{section.title}: {experiment}"
    return replace(section, key=f"{section.key}-{end}", title=title, blocks=blocks)
