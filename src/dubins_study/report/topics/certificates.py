"""The section on certificates: how far the proof of each answer goes."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.attempts import PROOFS, SUCCESSES, is_true
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, Column, columns, marks
from dubins_study.report.elements.content import General, Section, Table, Topic
from dubins_study.report.elements.formats import count, digits, sentences, share
from dubins_study.report.elements.identity import best_first
from dubins_study.report.elements.looks import in_page_order, labels_of
from dubins_study.report.statistics.metrics import proof
from dubins_study.report.topics.summary import best_solvers
from dubins_study.study.judging.certify import PMP_TOLERANCE

COUNTS = (
    SOLVER,
    *columns(count, attempts="attempts"),
    *(Column(name, name, count) for name in PROOFS),
    *columns(count, bounds="lower bounds", false_bounds="false bounds"),
)
ERRORS = (
    SOLVER,
    *columns(digits(2), pmp_residual="worst residual"),
    *columns(count, multipliers="multipliers"),
    *columns(digits(2), costate_median="costate error, median", costate_error="worst"),
)


def proofs(attempts: pd.DataFrame) -> pd.DataFrame:
    """One row per solver; a value that none of its rows has is missing.

    Columns: solver, attempts, certified (attempts), one count per proof; pmp_residual (largest
    among the right answers); multipliers (answers whose multipliers can be compared),
    costate_median and costate_error (median and largest error of those); bounds (attempts with
    a lower bound), false_bounds;
    enclosed (attempts whose reference length has proven bounds), open (those of them whose
    bounds are apart by more than a hundredth: the data leave open on which side of a jump the
    target lies) and width (largest relative distance of the other bounds).
    """
    kinds, right = proof(attempts), attempts["verdict"].isin(SUCCESSES)
    # Multipliers can be compared with costates only if the path arrives and is an extremal; those
    # of a path that does not arrive are at best a proof of infeasibility. A single arc is excluded
    # too: only nu3 = 0 at its end and H = 0 restrict its costates, which leaves a whole family.
    extremal = attempts["gap"].notna() & (attempts["pmp_residual"] <= PMP_TOLERANCE)
    error = attempts["costate_error"].where(extremal & ~attempts["word"].isin(("L", "R")))
    high = attempts["reference_high"].where(attempts["reference_high"] > 0)
    width = (high - attempts["reference_low"]) / high
    counts = {"certified": attempts["proof"].notna(), **{kind: kinds.eq(kind) for kind in PROOFS}}
    counts |= {"multipliers": error.notna(), "bounds": attempts["lower_bound"].notna()}
    counts |= {"false_bounds": is_true(attempts["false_bound"])}
    counts |= {"enclosed": width.notna(), "open": width > _OPEN}
    solver = attempts["solver"]
    frame = pd.DataFrame(counts).groupby(solver).sum()
    return frame.assign(
        attempts=solver.groupby(solver).size(),
        pmp_residual=attempts["pmp_residual"].where(right).groupby(solver).max(),
        costate_median=error.groupby(solver).median(),
        costate_error=error.groupby(solver).max(),
        width=width.where(width <= _OPEN).groupby(solver).max(),
    ).reset_index()


_OPEN = 0.01


def certificates_section(results: Results) -> Section | None:
    """Counts of proofs, the worst residuals, and the width of the enclosures."""
    frame = in_page_order(proofs(results.attempts), results)
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
        "Of the optimal answers the worst violation of Pontryagin's conditions. Costate "
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
    widest, jumps = frame["width"].max(), int(frame["open"].max())
    return sentences(
        f"The widest interval around a shortest length is {digits(2)(widest)} of it: as much as "
        "the rounding of the data leaves open."
        if widest == widest  # not NaN: some interval is narrow
        else "",
        f"{jumps} intervals hold the lengths on both sides of a jump, since the target is nearer "
        "to a turning circle, or to the axis, than the data can tell."
        if jumps
        else "",
    )


def _reported(frame: pd.DataFrame) -> str:
    compared = frame[frame["multipliers"] > 0].sort_values("costate_error")
    bounds, false = int(frame["bounds"].sum()), int(frame["false_bounds"].sum())
    return sentences(
        *(
            "The multipliers that solvers report with an extremal are off its own costates by at "
            f"most {digits(2)(worst['costate_error'])} ({worst['label']}, whose median is "
            f"{digits(2)(worst['costate_median'])})."
            for worst in compared.tail(1).to_dict("records")
        ),
        f"Of {count(bounds)} lower bounds that solvers report {count(false)} lie above the "
        "shortest length."
        if bounds
        else "",
    )


TOPIC = Topic("certificates", certificates_section, General.POOLED)
