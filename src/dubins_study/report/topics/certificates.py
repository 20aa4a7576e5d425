"""The section on certificates: how far the proof of each answer goes."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.attempts import PROOFS
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, Column, columns, marks
from dubins_study.report.elements.content import General, Section, Table, Topic
from dubins_study.report.elements.formats import count, digits, sentences, share
from dubins_study.report.elements.identity import best_first
from dubins_study.report.elements.looks import in_page_order, labels_of
from dubins_study.report.topics.summary import best_solvers

COUNTS = (
    SOLVER,
    *columns(count, attempts="attempts"),
    *(Column(name, name, count) for name in PROOFS),
    *columns(count, bounds="lower bounds", false_bounds="false bounds"),
)
ERRORS = (
    SOLVER,
    *columns(digits(2), pmp_residual="worst residual", cut_margin="least cut margin, rad"),
    *columns(count, multipliers="multipliers"),
    *columns(digits(2), costate_median="costate error, median", costate_error="worst"),
)


def certificates_section(results: Results) -> Section | None:
    """Counts of proofs, the worst residuals, and the width of the enclosures."""
    frame = in_page_order(results.attempts.proofs(), results)
    if not frame["certified"].sum():
        return None
    text = (
        "Every answer is certified from its controls alone. Proved: the length agrees with a "
        "rigorous interval around the shortest one, and Pontryagin's conditions hold, for the "
        "branch best the cut margin too; or there is provably no path, and none was returned. "
        "Bounded: the solver's own bound is within the tolerance. Extremal: Pontryagin's "
        "conditions alone, which are necessary and not sufficient."
    )
    frame = frame.assign(label=frame["solver"].map(labels_of(results)))
    text = sentences(text, _proved(frame), _enclosed(frame), _reported(frame))
    counts = Table(
        "proof-counts",
        "Attempts by how far their proof goes; failed, coarse or rippled answers have none, nor "
        "has what the presolve answered in an engine's place. Bounds that solvers report, and how "
        "many of them lie above the shortest length.",
        frame,
        COUNTS,
        marks(frame, "false_bounds"),
    )
    errors = Table(
        "certificates",
        "Of the optimal answers the worst violation of Pontryagin's conditions and, of the branch "
        "best, the least cut margin: above 0 a path is the shortest to its own end. Costate "
        "error: a solver's multipliers against the costates of its own path, if that arrives and "
        "has more than one arc.",
        frame,
        ERRORS,
    )
    best, solvers = best_solvers(results), frame["solver"]
    tables = *best_first(counts, solvers, best), *best_first(errors, solvers, best)
    lead = "See how far the proof of each method's answers goes."
    return Section("certificates", "Certificates", text, tables, lead)


def _proved(frame: pd.DataFrame) -> str:
    attempts, proved = int(frame["attempts"].sum()), int(frame["proved"].sum())
    others = ", ".join(f"{count(frame[name].sum())} {name}" for name in PROOFS[1:])
    return (
        f"Of {count(attempts)} attempts {count(proved)} are proved ({share(proved / attempts)}; "
        f"{others})."
    )


def _enclosed(frame: pd.DataFrame) -> str:
    if not frame["enclosed"].sum():
        return ""
    widest, jumps = frame["width"].max(), int(frame["open"].max())
    sentences = []
    if widest == widest:  # not NaN: some interval is narrow
        sentences.append(
            f"The widest interval around a shortest length is {digits(2)(widest)} of it: as much "
            "as the rounding of the data leaves open."
        )
    if jumps:
        sentences.append(
            f"{jumps} intervals hold the lengths on both sides of a jump, since the target is "
            "nearer to a turning circle, or to the axis, than the data can tell."
        )
    return " ".join(sentences)


def _reported(frame: pd.DataFrame) -> str:
    parts = []
    compared = frame[frame["multipliers"] > 0]
    if len(compared):
        ranked = compared.sort_values("costate_error").to_dict("records")
        best, worst = ranked[0], ranked[-1]
        part = (
            "the multipliers of an extremal are off its own costates by at most "
            f"{digits(2)(worst['costate_error'])} ({worst['label']}, whose median is "
            f"{digits(2)(worst['costate_median'])})"
        )
        if len(compared) > 1:
            part += f", at best by {digits(2)(best['costate_error'])} ({best['label']})"
        parts.append(part)
    if bounds := int(frame["bounds"].sum()):
        false = int(frame["false_bounds"].sum())
        parts.append(
            f"of {count(bounds)} lower bounds {count(false)} lie above the shortest length"
        )
    return f"What solvers report in addition to a path: {'; '.join(parts)}." if parts else ""


TOPIC = Topic("certificates", certificates_section, General.POOLED)
