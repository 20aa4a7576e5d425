"""How far the proofs of the answers go."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.reduction import Reduction
from dubins_study.report.data.tally import PROOFS
from dubins_study.report.statistics.metrics import solver_order


def certificates(attempts: Reduction) -> pd.DataFrame:
    """One row a solver; what is not measured for any of its rows is NaN.

    Columns: solver, attempts, one count per proof, pmp_residual (worst of the optimal answers),
    cut_margin (least of the optimal answers to `best`, rad), multipliers (answers whose
    multipliers are `reduction.compared`), costate_median and costate_error (median and largest of
    those), bounds (attempts with a lower bound), false_bounds.
    """
    records = []
    for solver in solver_order(list(attempts.solvers)):
        own = attempts.solvers[solver]
        errors = own.spread("costate_error")
        record: dict[str, object] = {"solver": solver, "attempts": own.attempts}
        record |= {name: own.count("proof", name) for name in PROOFS}
        record |= {
            "pmp_residual": own.spread("pmp_residual").largest,
            "cut_margin": own.spread("cut_margin").least,
            "multipliers": errors.size,
            "costate_median": errors.median,
            "costate_error": errors.largest,
            "bounds": own.count("bounds"),
            "false_bounds": own.count("false_bounds"),
        }
        records.append(record)
    return pd.DataFrame.from_records(records)
