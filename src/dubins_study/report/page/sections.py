"""The report's sections in the order of the page, and the attempts that each section shows."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from enum import Enum, auto
from typing import NamedTuple

from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import Section
from dubins_study.report.elements.formats import count, slug
from dubins_study.report.elements.names import with_labels
from dubins_study.report.explorer.section import explorer_section
from dubins_study.report.interactive.section import attempts_section
from dubins_study.report.topics.agreement.section import agreement_section, formulations_section
from dubins_study.report.topics.audit.section import audit_section
from dubins_study.report.topics.basins.section import basins_section
from dubins_study.report.topics.belief.section import belief_section
from dubins_study.report.topics.bias.section import bias_section
from dubins_study.report.topics.caution.section import caution_section
from dubins_study.report.topics.certificates.section import certificates_section
from dubins_study.report.topics.comparison.section import comparison_section
from dubins_study.report.topics.convergence.section import convergence_section
from dubins_study.report.topics.cost.section import cost_section
from dubins_study.report.topics.decision.section import decision_section
from dubins_study.report.topics.discretisation.section import discretisation_section
from dubins_study.report.topics.existence.section import existence_section
from dubins_study.report.topics.failures.section import failures_section
from dubins_study.report.topics.findings.section import findings_section
from dubins_study.report.topics.ladder.section import ladder_section
from dubins_study.report.topics.limits.section import limits_section
from dubins_study.report.topics.map.section import map_section
from dubins_study.report.topics.matrix.section import matrix_section
from dubins_study.report.topics.paper.section import figures_section, paper_section
from dubins_study.report.topics.plane.section import plane_section
from dubins_study.report.topics.proofs.section import proofs_section
from dubins_study.report.topics.radius.section import radius_section
from dubins_study.report.topics.runs.section import runs_section
from dubins_study.report.topics.scale.section import scale_section
from dubins_study.report.topics.solvers.section import solvers_section
from dubins_study.report.topics.success.section import success_section
from dubins_study.report.topics.summary.section import summary_section
from dubins_study.report.topics.time.section import time_section


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
        counted: whether its numbers count every attempt. Other sections need single rows, and show
            a sample if there are too many.
    """

    title: str
    write: Callable[[Results], Section | None]
    about: General | str
    enters: tuple[General, ...] = ()
    counted: bool = False


EVERY, POOLED, COMPARED, DECIDED = General
BENCHMARK = "benchmark"
TOPICS = (
    # the answer
    Topic("what to use", decision_section, DECIDED),
    Topic("what the study found", findings_section, BENCHMARK),
    Topic("what not to conclude", caution_section, DECIDED),
    # the comparison
    Topic("formulation by engine", matrix_section, BENCHMARK, counted=True),
    Topic("summary", summary_section, POOLED, counted=True),
    Topic("success and gaps", success_section, POOLED, counted=True),
    Topic("where no path exists", existence_section, POOLED, counted=True),
    Topic("whom one can believe", belief_section, BENCHMARK),
    Topic("certificates", certificates_section, POOLED, counted=True),
    Topic("the comparison of methods", comparison_section, BENCHMARK),
    Topic("cost where it arises", cost_section, BENCHMARK),
    Topic("time", time_section, COMPARED),
    Topic("agreement", agreement_section, COMPARED),
    Topic("agreement of formulations", formulations_section, BENCHMARK),
    # the problem and the paper
    Topic("the explorer", explorer_section, EVERY, counted=True),
    Topic("length, time and word against radius", radius_section, EVERY),
    Topic("the paper's tables", paper_section, "paper", (POOLED, COMPARED)),
    Topic("the audit of the paper", audit_section, "paper", counted=True),
    Topic("the paper's figures", figures_section, "paper"),
    # studies of one thing each
    Topic("work and precision", discretisation_section, "discretisation"),
    # Not compared: a plane has a hundred thousand questions that only the closed form answers.
    Topic("the target plane", plane_section, "plane", (POOLED,)),
    Topic("the plane, counted", map_section, EVERY, counted=True),
    Topic("where initial guesses lead", basins_section, "basins"),
    Topic("the interior-point bias", bias_section, "bias"),
    Topic("scale invariance", scale_section, "scale"),
    Topic("the order of convergence", convergence_section, "convergence"),
    Topic("the ladder toward a circle", ladder_section, "ladder"),
    Topic("what a proof costs", proofs_section, "proofs"),
    Topic("failures", failures_section, POOLED, counted=True),
    # single attempts, and what they rest on
    Topic("single attempts", attempts_section, EVERY, counted=True),
    Topic("the solvers and their settings", solvers_section, EVERY, counted=True),
    Topic("the runs and their machines", runs_section, EVERY, counted=True),
    Topic("limits", limits_section, EVERY, counted=True),
)
KEYS = tuple(dict.fromkeys(topic.about for topic in TOPICS if isinstance(topic.about, str)))


def sections_of(topic: Topic, results: Results) -> Iterator[Section]:
    """The topic's sections: one per experiment if several name it, none without rows, else one."""
    selections = _selections(topic, results)
    for name, selection in selections.items():
        section = topic.write(selection)
        if section is None:
            continue
        if len(selections) > 1:
            section = _named_after(section, name)
        shown = section if topic.counted else _with_sample(section, results)
        yield with_labels(shown, results)


def _selections(topic: Topic, results: Results) -> dict[str, Results]:
    """Experiment, or empty -> attempts, for each section that the topic may have."""
    keys: dict[str, str | None] = {}
    for run in results.folders:
        if run.name in results.attempts.experiments:  # the rows of other folders are all left out
            keys.setdefault(run.name, run.section)
    if isinstance(topic.about, str):
        about = [name for name, key in keys.items() if key == topic.about]
        return {name: results.only({name}) for name in about}
    if topic.about is EVERY:
        return {"": results}
    names = _pooled(keys, COMPARED if topic.about is DECIDED else topic.about)
    if topic.about is DECIDED:
        names = {name for name, key in keys.items() if key == BENCHMARK} or names
    if names:
        return {"": results.only(names)}
    # If the report has only studies, they are pooled.
    return {} if topic.about is COMPARED else {"": results}


def _pooled(keys: Mapping[str, str | None], kind: General) -> set[str]:
    """The experiments, with the keys that they give, that enter the sections of a general kind."""
    apart = {topic.about for topic in TOPICS} - {t.about for t in TOPICS if kind in t.enters}
    return {name for name, key in keys.items() if key not in apart}


def _named_after(section: Section, experiment: str) -> Section:
    """The section with the experiment's name in its title, its anchor and its files' names."""
    end = slug(experiment)
    blocks = tuple(replace(block, name=f"{block.name}-{end}") for block in section.blocks)
    title, key = f"{section.title}: {experiment}", f"{section.key}-{end}"
    return replace(section, key=key, title=title, blocks=blocks)


def _with_sample(section: Section, results: Results) -> Section:
    """The section with a sentence about the sample, if it shows only a sample of the attempts."""
    if not results.sampled:
        return section
    kept, attempts = len(results.rows), results.attempts.count
    sentence = (
        f"Where single attempts are shown or compared, they are {count(kept)} of the "
        f"{count(attempts)}: all those at some of the scenarios, drawn by the hashes that name them"
    )
    if section.key == "time":
        sentence += "; quartiles and medians are of all"
    return replace(section, text=f"{section.text} {sentence}.")
