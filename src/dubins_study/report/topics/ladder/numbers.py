"""How close to a turning circle each solver is right, from rows."""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.statistics.metrics import FloatArray, solver_order

SIDES = ("front, inside", "front, outside", "rear, inside", "rear, outside")
JUMP = "front, inside"  # where the shortest length is by up to 2 pi R above that across the circle
# what became of an attempt, best first
FINDINGS = ("right", "coarse", "by its miss", "wrong basin", "no path")
ANSWERED = ("right", "coarse")  # the shortest path, to whatever accuracy
SHORTER = 1e-4  # relative; an answer shorter than the shortest by this is short by its miss


def rungs(rows: pd.DataFrame) -> pd.DataFrame:
    """Every attempt with its place on the ladder and what became of it.

    `right`: optimal, and as long as the scenario's shortest path. `by its miss`: optimal as the
    check says it, which relaxes its reference over the miss made, but shorter than the scenario's
    shortest path. `coarse`: longer, of the same shape. `wrong basin`: longer, of another.
    `no path`: it does not arrive, or there is none.

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
    """One row a solver, side and rung, of what `rungs` returns.

    Columns solver, side, rung, attempts, finding (the worst of them), false_claims.
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
    """One row a solver, of what `ladder` returns.

    Columns solver; one per side: the least margin down to which, from the widest one on, every
    answer is the shortest path, coarse or not (0 if every answer is, NaN if not even the first);
    attempts, coarse and by_miss (rungs of the jump's inner side), false_claims.
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
    """Solver -> the widest rung at which its miss shortens its path, the widest solver first."""
    short = attempts[attempts["finding"] == "by its miss"]
    return short.groupby("solver")["rung"].max().sort_values(ascending=False)


def right_everywhere(attempts: pd.DataFrame) -> dict[str, bool]:
    """Solver -> whether all its answers are the shortest path, coarse or not."""
    right = attempts["finding"].isin(ANSWERED).groupby(attempts["solver"]).all()
    return {solver: bool(right[solver]) for solver in solver_order(list(right.index))}
