"""The report's sections in the order of the page; each is left out if it has no rows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from dubins_study.report.data.results import Results
from dubins_study.report.page.content import Section, count
from dubins_study.report.topics.agreement.section import agreement_section
from dubins_study.report.topics.audit.section import audit_section
from dubins_study.report.topics.basins.section import basins_section
from dubins_study.report.topics.bias.section import bias_section
from dubins_study.report.topics.certificates.section import certificates_section
from dubins_study.report.topics.convergence.section import convergence_section
from dubins_study.report.topics.ladder.section import ladder_section
from dubins_study.report.topics.map.section import map_section
from dubins_study.report.topics.paper.section import figures_section, paper_section
from dubins_study.report.topics.plane.section import plane_section
from dubins_study.report.topics.proofs.section import proofs_section
from dubins_study.report.topics.radius.section import radius_section
from dubins_study.report.topics.runs.section import runs_section
from dubins_study.report.topics.scale.section import scale_section
from dubins_study.report.topics.summary.section import success_section, summary_section
from dubins_study.report.topics.time.section import discretisation_section, time_section

SECTIONS: dict[str, Callable[[Results], Section | None]] = {
    "summary": summary_section,
    "the paper's tables": paper_section,
    "the audit of the paper": audit_section,
    "the paper's figures": figures_section,
    "length, time and word against radius": radius_section,
    "agreement": agreement_section,
    "success and gaps": success_section,
    "certificates": certificates_section,
    "time": time_section,
    "work and precision": discretisation_section,
    "the target plane": plane_section,
    "the plane, counted": map_section,
    "where starting points lead": basins_section,
    "the interior-point bias": bias_section,
    "scale invariance": scale_section,
    "the order of convergence": convergence_section,
    "the ladder toward a circle": ladder_section,
    "what a proof costs": proofs_section,
    "the runs and their machines": runs_section,
}

# their numbers count every attempt, however many there are; those of others need single rows
_COUNTED = ("summary", "success", "certificates", "map", "audit", "runs")


def told_of_sample(section: Section, results: Results) -> Section:
    """The section with a sentence on what it leaves out, if it does."""
    if not results.sampled or section.key in _COUNTED:
        return section
    kept, attempts = len(results.rows), results.attempts.count
    said = (
        f"Where single attempts are shown or compared, they are {count(kept)} of the "
        f"{count(attempts)}: all those at some of the scenarios, drawn by the hashes that name them"
    )
    if section.key == "time":
        said += "; quartiles and medians are of all"
    return replace(section, text=f"{section.text} {said}.")
