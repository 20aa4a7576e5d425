"""Two runs, solver by solver: questions that both were asked, what changed, and paired tests."""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple

import numpy as np
import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.statistics.intervals import (
    PairedTest,
    averages,
    bootstrap,
    geometric_means,
    holm,
    medians,
    sign_test,
    wilcoxon_test,
)
from dubins_study.report.statistics.metrics import solver_order, success
from dubins_study.study.arrays import FloatArray
from dubins_study.study.scenario import COLUMNS
from dubins_study.study.tolerances import ARRIVES

_PAIR = ["solver", "scenario_id", "branch", "initial_guess"]
_SHARED = [*COLUMNS, "answerable"]
SIDES = ("base", "new")


def pairs(base: Results, new: Results) -> pd.DataFrame:
    """The questions that both runs have attempts at, one row per solver and question.

    Columns solver, scenario_id, branch, initial_guess, those of the scenario, answerable, and for
    each of `SIDES` right (share of the repeats that the check accepts), false (whether any repeat
    has a false claim or bound), gap (median of the repeats that arrive) and time (median, s).
    """
    old = _questions(base).drop(columns=_SHARED).add_suffix("_base")
    measured = {name: f"{name}_new" for name in ("right", "false", "gap", "time")}
    joined = old.join(_questions(new).rename(columns=measured), how="inner")
    return joined.reset_index().sort_values(_PAIR, ignore_index=True)


def unpaired(base: Results, new: Results) -> pd.DataFrame:
    """solver, only_base, only_new: how many questions only one of the runs was asked, if any."""
    indexes = [_questions(results).index for results in (base, new)]
    counts = {
        f"only_{side}": mine.difference(other).to_frame(index=False).groupby("solver").size()
        for side, mine, other in zip(SIDES, indexes, indexes[::-1], strict=True)
    }
    frame = pd.DataFrame(counts).fillna(0).astype(int)
    return frame[frame.sum(axis=1) > 0].rename_axis("solver").reset_index()


def _questions(results: Results) -> pd.DataFrame:
    rows = results.rows[results.rows["verdict"].ne("undecided")]
    false = rows["false_claim"].eq(True) | rows["false_bound"].eq(True)
    attempts = rows[[*_PAIR, *_SHARED, "gap"]].assign(
        right=success(rows).fillna(False).astype(float),
        false=false.fillna(False).astype(bool),
        time=rows["wall_s"],
    )
    how = dict.fromkeys(_SHARED, "first") | {"right": "mean", "false": "any"}
    return attempts.groupby(_PAIR, observed=True).agg(how | {"gap": "median", "time": "median"})


class MachineSpeed(NamedTuple):
    """How many times as long the same work took in the new run; 2: a machine half as fast.

    `ratio`, the range from `low` to `high` that it may have, and `evidence`: what says so.
    """

    ratio: float
    low: float
    high: float
    evidence: str


_FEWEST = 5  # probes of a run: the median of fewer has no interval worth the name


def unchanged_solvers(base: Results, new: Results) -> list[str]:
    """The solvers whose code, settings and packages are the same in both runs."""
    before, after = (results.folders[0].manifest.code_digests for results in (base, new))
    return [spec for spec, digest in before.items() if after.get(spec) == digest]


def machine_speed(
    base: Results, new: Results, pairs: pd.DataFrame, unchanged: Collection[str]
) -> MachineSpeed | None:
    """The machine's speed, from solvers that cannot have changed, else from calibration probes.

    A solver of the same code took as many times as long as its machine did: the geometric mean of
    their ratios, and the range of their intervals, since a load slows some work more than other.
    The probe, a short piece of work that is timed every two seconds, notices less of a load; it
    stands in where no solver is unchanged: the medians' ratio, the ends of their 95 % intervals
    divided crosswise. None if no solver is unchanged and a run has fewer than five probes.
    """
    timed = pairs[pairs["solver"].isin(unchanged)].groupby("solver", observed=True)
    ratios = np.array([_ratio(_timed(rows)) for _, rows in timed]).reshape(-1, 3)
    known = ratios[(np.isfinite(ratios) & (ratios > 0)).all(axis=1)]
    if len(known):
        mean = float(np.exp(np.log(known[:, 0]).mean()))
        low, high = float(known[:, 1].min()), float(known[:, 2].max())
        plural = "" if len(known) == 1 else "s"
        return MachineSpeed(mean, low, high, f"{len(known)} solver{plural} of the same code")
    took = [_probe_seconds(results) for results in (base, new)]
    if min(map(len, took)) < _FEWEST:
        return None
    before, after = (bootstrap(pd.DataFrame({"probe": each}), medians).iloc[0] for each in took)
    return MachineSpeed(
        float(after["estimate"] / before["estimate"]),
        float(after["low"] / before["high"]),
        float(after["high"] / before["low"]),
        f"{len(took[0])} and {len(took[1])} calibration probes",
    )


def _probe_seconds(results: Results) -> list[float]:
    runs = [run for folder in results.folders for run in folder.manifest.runs]
    return [probe.took for run in runs for probe in run.probes]


# A path that arrives may miss its target by this many radii, so its length is known to as much of
# max(length, R) only: smaller gaps are no difference in accuracy.
GAP_FLOOR = ARRIVES
# A question's answer lost accuracy if its gap is more than so many times as large.
WORSE_GAP = 10.0

ENDS = ("", "_low", "_high")


def solver_changes(
    pairs: pd.DataFrame, speed: MachineSpeed | None, unchanged: Collection[str]
) -> pd.DataFrame:
    """One row per solver, in the order of tables; times of `unchanged` solvers are as measured.

    Returns:
        Columns solver; questions (that have a path); right_base, right_new: shares of them;
        right_change with _low and _high: their difference, with its bootstrap interval over
        scenarios; lost, gained: questions that were right in every repeat of one run and of none in
        the other; right_p: of the exact sign test, with Holm's correction over the solvers;
        denials, denials_lost: questions without a path, and those no longer recognised;
        false_new: questions with a false claim or bound in the new run alone;
        gap_base, gap_new: the largest gap of the answers that are right in both runs; gap_worse:
        how many of them lost accuracy; gap_p: of the sign test of gaps above the floor;
        timed: questions right in both; time_base, time_new: geometric means of their times, s;
        time_ratio with _low and _high: new / base, the machine's speed taken out if it is known;
        time_p: of Wilcoxon's test of these ratios, NaN if the machine's speed is not known;
        same_code. NaN where there is nothing to compare, also for the times of unchanged solvers.
    """
    lines: list[dict[str, object]] = []
    for solver in solver_order(pairs["solver"].unique().tolist()):
        rows, same = pairs[pairs["solver"] == solver], solver in unchanged
        line = {"solver": solver, "same_code": same}
        lines.append(
            line | _success(rows) | _accuracy(rows) | _times(rows, None if same else speed)
        )
    frame = pd.DataFrame(lines)
    tests = [name for name in frame.columns if name.endswith("_p")]
    return frame.assign(**{name: holm(frame[name]) for name in tests})


def lost(pairs: pd.DataFrame) -> pd.Series[bool]:
    """Whether each question was right in every repeat of the base and in none of the new run."""
    return pairs["right_base"].eq(1) & pairs["right_new"].eq(0)


def newly_false(pairs: pd.DataFrame) -> pd.Series[bool]:
    """Whether each question has a false claim or bound in the new run alone."""
    return pairs["false_new"] & ~pairs["false_base"]


def less_accurate(pairs: pd.DataFrame) -> pd.Series[bool]:
    """Whether an answer that is right in both runs has a gap that is larger by `WORSE_GAP`."""
    gap = _gaps(pairs)
    return _right_in_both(pairs) & (gap["new"] > WORSE_GAP * gap["base"])


def _gaps(pairs: pd.DataFrame) -> pd.DataFrame:
    return pd.DataFrame({side: pairs[f"gap_{side}"].clip(lower=GAP_FLOOR) for side in SIDES})


def _right_in_both(pairs: pd.DataFrame) -> pd.Series[bool]:
    return pairs["answerable"] & pairs["right_base"].eq(1) & pairs["right_new"].eq(1)


def _success(pairs: pd.DataFrame) -> dict[str, object]:
    asked, without = pairs[pairs["answerable"]], pairs[~pairs["answerable"]]
    wrong = [1 - asked[f"right_{side}"].to_numpy() for side in SIDES]
    change = pd.DataFrame({"change": wrong[0] - wrong[1]}, index=asked["scenario_id"])
    interval = bootstrap(change, averages).iloc[0][["estimate", "low", "high"]]
    return {
        "questions": len(asked),
        **{f"right_{side}": asked[f"right_{side}"].mean() for side in SIDES},
        **{f"right_change{end}": value for end, value in zip(ENDS, interval, strict=True)},
        "lost": int(lost(asked).sum()),
        "gained": int((asked["right_base"].eq(0) & asked["right_new"].eq(1)).sum()),
        "right_p": _p(sign_test(wrong[1], wrong[0])),
        "denials": len(without),
        "denials_lost": int(lost(without).sum()),
        "false_new": int(newly_false(pairs).sum()),
    }


def _accuracy(pairs: pd.DataFrame) -> dict[str, object]:
    both = pairs[_right_in_both(pairs)]
    gap = _gaps(both)
    return {f"gap_{side}": both[f"gap_{side}"].max() for side in SIDES} | {
        "gap_worse": int(less_accurate(pairs).sum()),
        "gap_p": _p(sign_test(gap["new"], gap["base"])),
    }


def _timed(pairs: pd.DataFrame) -> pd.DataFrame:
    """The times of both runs, s, by scenario, of the questions that are right in both."""
    both = pairs[_right_in_both(pairs) & pairs["time_base"].gt(0) & pairs["time_new"].gt(0)]
    times = pd.DataFrame({side: both[f"time_{side}"].to_numpy() for side in SIDES})
    return times.set_axis(both["scenario_id"].to_numpy(), axis=0)


def _ratio(times: pd.DataFrame) -> FloatArray:
    """Time in the new run by that in the base, as measured: geometric mean, low, high."""
    ratios = bootstrap(times, geometric_means(0.0), "base")
    return ratios.loc["new", ["estimate", "low", "high"]].to_numpy(np.float64)


def _times(pairs: pd.DataFrame, speed: MachineSpeed | None) -> dict[str, object]:
    times = _timed(pairs)
    means = np.exp(np.log(times).mean())
    # crosswise: the slower the machine may have been, the faster the solver
    machine = (1.0, 1.0, 1.0) if speed is None else (speed.ratio, speed.high, speed.low)
    # tested against the machine's own change, so that a slower machine is no slower solver
    test = wilcoxon_test(times["new"].to_numpy(), times["base"].to_numpy() * machine[0])
    return {
        "timed": len(times),
        "time_base": float(means["base"]),
        "time_new": float(means["new"]),
        **dict(zip((f"time_ratio{end}" for end in ENDS), _ratio(times) / machine, strict=True)),
        "time_p": float("nan") if speed is None else _p(test),
    }


def _p(test: PairedTest) -> float:
    return test.p if test.pairs else float("nan")
