"""How far the proofs of the answers go, from rows."""

from __future__ import annotations

import numpy as np
import pandas as pd

from report.metrics import solver_order, success
from study.certificate import PMP_TOLERANCE

PROOFS = ("proved", "bounded", "extremal", "none")


def proof(rows: pd.DataFrame) -> pd.Series:
    """How far each attempt's proof goes; `none` of a process that did not come back."""
    return rows["proof"].where(rows["proof"].isin(PROOFS), "none")


def compared(rows: pd.DataFrame) -> pd.Series[bool]:
    """Whether an answer's multipliers can be compared with the costates of its own path.

    Only an extremal that arrives has costates to compare with: what a solver reports of a path
    that does not is a proof of infeasibility at best. A single arc has a whole family of them,
    which nothing but nu3 = 0 at its end and H = 0 ties.
    """
    arrived = rows["gap"].notna() & rows["costate_error"].notna()
    tied = ~rows["word"].isin(["L", "R"]) & (rows["pmp_residual"] <= PMP_TOLERANCE)
    return arrived & tied


def certificates(rows: pd.DataFrame) -> pd.DataFrame:
    """One row a solver; what is not measured for any of its rows is NaN.

    Columns: solver, attempts, one count per proof, pmp_residual (worst of the optimal answers),
    cut_margin (least of the optimal answers to `best`, rad), multipliers (answers whose
    multipliers are `compared`), costate_median and costate_error (median and largest of those),
    bounds (attempts with a lower bound), false_bounds.
    """
    word, tied = proof(rows), compared(rows)
    records = []
    for solver in solver_order(rows["solver"].tolist()):
        mine = rows["solver"] == solver
        own, words = rows[mine], word[mine]
        right = own[success(own)]
        record: dict[str, object] = {"solver": solver, "attempts": len(own)}
        record |= {name: int((words == name).sum()) for name in PROOFS}
        record |= {
            "pmp_residual": right["pmp_residual"].max(),
            "cut_margin": right.loc[right["branch"] == "best", "cut_margin"].min(),
            "multipliers": int(tied[mine].sum()),
            "costate_median": own.loc[tied[mine], "costate_error"].median(),
            "costate_error": own.loc[tied[mine], "costate_error"].max(),
            "bounds": int(own["lower_bound"].notna().sum()),
            "false_bounds": int(own["false_bound"].fillna(False).astype(bool).sum()),
        }
        records.append(record)
    return pd.DataFrame.from_records(records)


def enclosures(rows: pd.DataFrame) -> pd.Series:
    """Width of the proven interval around each question's shortest length, relative to its end.

    One for each question of positive length; the others have no width to speak of.
    """
    asked = rows.drop_duplicates(["scenario_id", "branch"])
    high, low = asked["reference_high"], asked["reference_low"]
    known = high.notna() & low.notna() & (high > 0)
    width: pd.Series = ((high - low) / high)[known].astype(np.float64)
    return width
