"""How close to a turning circle each solver still finds the shortest path."""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.statistics.metrics import solver_order
from dubins_study.study.path import FloatArray

SIDES = ("front, inside", "front, outside", "rear, inside", "rear, outside")
JUMP = "front, inside"  # here the length is up to 2 pi R above that on the circle's other side
# Results of an attempt, the best first.
FINDINGS = ("right", "coarse", "by its miss", "wrong basin", "no path")
ANSWERED = ("right", "coarse")  # the shortest path, accurate or not
SHORTER = 1e-4  # relative; an answer that is shorter than the optimum by this profits from its miss


def rungs(rows: pd.DataFrame) -> pd.DataFrame:
    """Every attempt with its place on the ladder and its finding.

    `right`: optimal, and as long as the scenario's shortest path. `by its miss`: the check accepts
    it as optimal, since it relaxes the reference over the miss, but it is shorter than the
    scenario's shortest path. `coarse`: longer, but with the same shape. `wrong basin`: longer, with
    another shape. `no path`: no path was returned, or it does not arrive.

    Returns:
        Columns solver, scenario_id, side, rung (margin as a power of ten), finding, false_claim,
        miss (radii).
    """
    group = rows[(rows["branch"] == "best") & (rows["margin"] > 0)]
    cos, sin = np.cos(group["heading"]), np.sin(group["heading"])
    ahead = (group["target_x"] - group["x"]) * cos + (group["target_y"] - group["y"]) * sin
    half = np.where(ahead > 0, "front", "rear")
    inside = np.where(group["region"].str.endswith("disc"), "inside", "outside")
    return pd.DataFrame(
        {
            "solver": group["solver"],
            "scenario_id": group["scenario_id"],
            "side": [f"{a}, {b}" for a, b in zip(half, inside, strict=True)],
            "rung": np.round(np.log10(group["margin"])).astype("int64"),
            "finding": _findings(group),
            "false_claim": group["false_claim"].astype(bool),
            "miss": group["miss"] / group["radius"],
        }
    )


def _findings(rows: pd.DataFrame) -> list[str]:
    optimal = (rows["verdict"] == "optimal").to_numpy()
    longer = (rows["verdict"] == "longer").to_numpy()
    basin = rows["wrong_basin"].to_numpy(dtype=np.bool_)
    least = rows["reference_low"].fillna(0.0).to_numpy(dtype=np.float64)
    length: FloatArray = rows["length"].to_numpy(dtype=np.float64)
    short = length < least * (1 - SHORTER)
    chosen = np.select(
        [optimal & ~short, longer & ~basin, optimal & short, longer],
        FINDINGS[:4],
        default=FINDINGS[4],
    )
    return [str(finding) for finding in chosen]


def ladder(attempts: pd.DataFrame) -> pd.DataFrame:
    """One row per solver, side and rung, from the attempts that `rungs` returns.

    Columns solver, side, rung, attempts, finding (the worst one), false_claims.
    """
    place = {finding: i for i, finding in enumerate(FINDINGS)}
    grouped = attempts.assign(place=attempts["finding"].map(place)).groupby(
        ["solver", "side", "rung"], sort=False
    )
    frame = grouped.agg(
        attempts=("place", "size"), worst=("place", "max"), false_claims=("false_claim", "sum")
    ).reset_index()
    return frame.assign(finding=frame["worst"].map(dict(enumerate(FINDINGS)))).drop(columns="worst")


def down_to(table: pd.DataFrame) -> pd.DataFrame:
    """One row per solver, from the table that `ladder` returns.

    Columns solver; per side the smallest margin such that at this margin and all wider ones every
    answer is the shortest path, coarse or not (0 if this holds for all margins, NaN if it does not
    hold at the widest); attempts; coarse and by_miss (numbers of rungs on the inner side of the
    jump); false_claims.
    """
    records = []
    for solver in solver_order(table["solver"].tolist()):
        group = table[table["solver"] == solver]
        record: dict[str, object] = {"solver": solver, "attempts": int(group["attempts"].sum())}
        for side in SIDES:
            record[side] = _least(group[group["side"] == side].sort_values("rung", ascending=False))
        inner = group[group["side"] == JUMP]
        record["by_miss"] = int((inner["finding"] == "by its miss").sum())
        record["coarse"] = int((group["finding"] == "coarse").sum())
        record["false_claims"] = int(group["false_claims"].sum())
        records.append(record)
    return pd.DataFrame.from_records(records)


def _least(ladder: pd.DataFrame) -> float:
    wrong = np.flatnonzero(~ladder["finding"].isin(ANSWERED))
    if ladder.empty or (wrong.size and wrong[0] == 0):
        return float("nan")
    return 10.0 ** float(ladder["rung"].iloc[wrong[0] - 1]) if wrong.size else 0.0


def first_short_rung(attempts: pd.DataFrame) -> pd.Series[int]:
    """Solver -> the widest rung at which a miss shortens its path; the widest rung first."""
    short = attempts[attempts["finding"] == "by its miss"]
    return short.groupby("solver")["rung"].max().sort_values(ascending=False)


def right_everywhere(attempts: pd.DataFrame) -> dict[str, bool]:
    """Solver -> whether all its answers are the shortest path, coarse or not."""
    right = attempts["finding"].isin(ANSWERED).groupby(attempts["solver"]).all()
    return {solver: bool(right[solver]) for solver in solver_order(list(right.index))}
