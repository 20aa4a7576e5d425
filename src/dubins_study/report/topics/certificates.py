"""The section on certificates of answers."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.attempts import PROOFS, SUCCESSES, is_true
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, Column, columns, marks
from dubins_study.report.elements.content import General, Section, Table, Topic
from dubins_study.report.elements.formats import count, digits, sentences, share
from dubins_study.report.elements.looks import in_page_order
from dubins_study.report.statistics.metrics import proof
from dubins_study.study.judging.certify import PMP_TOLERANCE

COLUMNS = (
    SOLVER,
    *columns(count, attempts="attempts"),
    *(Column(name, name, count) for name in PROOFS),
    *columns(count, bounds="lower bounds", false_bounds="false bounds"),
    *columns(digits(2), pmp_residual="worst residual"),
    *columns(count, multipliers="multipliers"),
    *columns(digits(2), costate_median="costate error, median", costate_error="worst"),
)


def proofs(attempts: pd.DataFrame) -> pd.DataFrame:
    """Counts of proofs, one row per solver.

    A value that none of its rows has is missing. Columns: solver, attempts, certified (attempts),
    and a count for each of `PROOFS`; pmp_residual (largest among the right answers); multipliers
    (answers whose multipliers can be compared), costate_median and costate_error (median and
    largest error of those); bounds (attempts with a lower bound), false_bounds.
    """
    kinds = proof(attempts)
    right = attempts["verdict"].isin(SUCCESSES)
    # Multipliers can be compared with costates only if the path arrives and is an extremal; those
    # of a path that does not arrive are at best a proof of infeasibility. A single arc is excluded
    # too: only nu3 = 0 at its end and H = 0 restrict its costates, which leaves a whole family.
    extremal = attempts["gap"].notna() & (attempts["pmp_residual"] <= PMP_TOLERANCE)
    error = attempts["costate_error"].where(extremal & ~attempts["word"].isin(("L", "R")))
    counts = {
        "certified": attempts["proof"].notna(),
        **{kind: kinds.eq(kind) for kind in PROOFS},
        "multipliers": error.notna(),
        "bounds": attempts["lower_bound"].notna(),
        "false_bounds": is_true(attempts["false_bound"]),
    }
    solver = attempts["solver"]
    frame = pd.DataFrame(counts).groupby(solver).sum()
    return frame.assign(
        attempts=solver.groupby(solver).size(),
        pmp_residual=attempts["pmp_residual"].where(right).groupby(solver).max(),
        costate_median=error.groupby(solver).median(),
        costate_error=error.groupby(solver).max(),
    ).reset_index()


def certificates_section(results: Results) -> Section | None:
    """The section with counts of proofs and worst residuals."""
    frame = in_page_order(proofs(results.attempts), results)
    if not frame["certified"].sum():
        return None
    text = (
        "Every answer is certified from its controls alone. Proved: the length agrees with a "
        "rigorous interval around the shortest length, and Pontryagin's conditions hold. The "
        "branch best needs the cut margin too. Also proved: no path exists, and none was "
        "returned. Bounded: the solver's own bound is within the tolerance. Extremal: only "
        "Pontryagin's conditions hold, which are necessary but not sufficient."
    )
    table = Table(
        "certificates",
        "Number of attempts with each proof; failed, coarse or rippled answers and those of "
        "presolve have none. A false bound lies above the shortest length. Worst residual: the "
        "largest violation of Pontryagin's conditions by optimal answers. Costate error: the "
        "solver's multipliers against the costates of its path, if that arrives and has more than "
        "one arc.",
        frame,
        COLUMNS,
        marks(frame, "false_bounds"),
        dense=True,
    )
    lead = "See how far the proof of each method's answers goes."
    return Section("certificates", "Certificates", sentences(text, _proved(frame)), (table,), lead)


def _proved(frame: pd.DataFrame) -> str:
    """A sentence on how many attempts are proved."""
    attempts = int(frame["attempts"].sum())
    proved = int(frame["proved"].sum())
    others = ", ".join(f"{count(frame[name].sum())} {name}" for name in PROOFS[1:])
    return (
        f"Of {count(attempts)} attempts {count(proved)} are proved ({share(proved / attempts)}; "
        f"{others})."
    )


TOPIC = Topic("certificates", certificates_section, General.POOLED)
