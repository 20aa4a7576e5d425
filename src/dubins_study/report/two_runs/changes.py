"""Changes between two runs, solver by solver.

These are the questions that both runs were asked, differences in answers and times, and paired
tests.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd

from dubins_study.report.data.attempts import Mask
from dubins_study.report.data.results import Results
from dubins_study.report.elements.formats import some
from dubins_study.report.statistics.intervals import bootstrap, geometric_means, holm, sign_test
from dubins_study.report.statistics.metrics import solver_order, success
from dubins_study.study.scenario import COLUMNS
from dubins_study.study.tolerances import ARRIVES

_PAIR = ["solver", "scenario_id", "branch", "initial_guess"]
_SHARED = [*COLUMNS, "answerable"]
SIDES = ("base", "new")


def pairs(base: Results, new: Results) -> pd.DataFrame:
    """The questions that both runs attempted, one per row.

    A row is a solver's question with attempts in both runs. Columns: solver, scenario_id, branch,
    initial_guess, those of the scenario, and answerable. Four more have the suffix `_base` or
    `_new`: right (share of the repeats that the check accepts), false (whether any repeat has a
    false claim or bound), gap (median of the repeats that arrive) and time (median, s).
    """
    old = _questions(base).drop(columns=_SHARED).add_suffix("_base")
    new_names = {name: f"{name}_new" for name in ("right", "false", "gap", "time")}
    joined = old.join(_questions(new).rename(columns=new_names), how="inner")
    return joined.reset_index().sort_values(_PAIR, ignore_index=True)


def unpaired(base: Results, new: Results, pairs: pd.DataFrame) -> pd.DataFrame:
    """Numbers of questions that only one run has.

    Columns solver, only_base, only_new. Solvers without such questions are left out.
    """
    paired = pairs.groupby("solver").size()
    counts = {}
    for side, results in zip(SIDES, (base, new), strict=True):
        questions = _questions(results).groupby("solver").size()
        counts[f"only_{side}"] = questions.sub(paired, fill_value=0)
    frame = pd.DataFrame(counts).fillna(0).astype(int)
    return frame[frame.sum(axis=1) > 0].rename_axis("solver").reset_index()


def _questions(results: Results) -> pd.DataFrame:
    """A row per solver and question of one run.

    Columns: those of the scenario, answerable, right, false, gap and time, as in `pairs`. Open
    questions have no row.
    """
    rows = results.rows[~results.rows["left_open"]]
    false = rows["false_claim"].eq(True) | rows["false_bound"].eq(True)
    attempts = rows[[*_PAIR, *_SHARED, "gap"]].assign(
        right=success(rows).fillna(False).astype(float),
        false=false.fillna(False).astype(bool),
        time=rows["wall_s"],
    )
    aggregation = dict.fromkeys(_SHARED, "first") | {"right": "mean", "false": "any"}
    return attempts.groupby(_PAIR, observed=True).agg(
        aggregation | {"gap": "median", "time": "median"}
    )


class MachineSpeed(NamedTuple):
    """How the times of two runs' machines compare.

    `ratio` is how many times as long the same work took in the new run; 2 means a machine half as
    fast. `low` and `high` are the ends of its range. `evidence` names the source.
    """

    ratio: float
    low: float
    high: float
    evidence: str


def machine_speed(changes: pd.DataFrame) -> MachineSpeed | None:
    """The ratio of the machines' times, from unchanged solvers.

    A solver with the same code takes as many times as long as its machine does. `ratio` is the
    geometric mean of such solvers' ratios. The range joins their intervals, since a load slows some
    work more than other work. None comes back without such a solver.
    """
    unchanged = changes[changes["same_code"] & changes["time_ratio"].gt(0)]
    if unchanged.empty:
        return None
    return MachineSpeed(
        ratio=float(np.exp(np.log(unchanged["time_ratio"]).mean())),
        low=float(unchanged["time_ratio_low"].min()),
        high=float(unchanged["time_ratio_high"].max()),
        evidence=f"{some(len(unchanged), 'solver')} of the same code",
    )


def without_machine(changes: pd.DataFrame, speed: MachineSpeed | None) -> pd.DataFrame:
    """The changes with the machine's speed divided out.

    Only the times of solvers whose code changed are divided. The low end is divided by the high end
    of the speed and vice versa: the slower the machine, the faster the solver.
    """
    if speed is None:
        return changes
    frame = changes.copy()
    for key, machine in zip(TIME_RATIO, (speed.ratio, speed.high, speed.low), strict=True):
        frame[key] = frame[key].where(frame["same_code"], frame[key] / machine)
    return frame


# A path that arrives may miss its target by this many radii. So its length is known only to this
# share of max(length, R), and smaller gaps are no difference in accuracy.
GAP_FLOOR = ARRIVES
# An answer is less accurate if its gap is more than this many times as large.
WORSE_GAP = 10.0

TIME_RATIO = ["time_ratio", "time_ratio_low", "time_ratio_high"]


def solver_changes(base: Results, new: Results, pairs: pd.DataFrame) -> pd.DataFrame:
    """The changes of each solver.

    One row per solver, in the order of tables; times are as measured.

    Returns:
        Columns solver; same_code: whether its code, settings and packages are the same in both;
        questions (that have a path); right_base, right_new: shares of them; right_p: of the exact
        sign test, with Holm's correction over the solvers; lost, gained: questions that were right
        in every repeat of one run and of none in the other; timed: questions right in both;
        time_base, time_new: geometric means of their times, s; time_ratio with _low and _high: new
        / base, with its bootstrap interval over scenarios. NaN where there is nothing to compare.
    """
    before = base.folders[0].manifest.code_digests
    after = new.folders[0].manifest.code_digests
    lines: list[dict[str, object]] = []
    for solver in solver_order(pairs["solver"].unique().tolist()):
        same_code = after.get(solver) == before.get(solver, "")
        rows = pairs[pairs["solver"] == solver]
        answers = _answers(rows[rows["answerable"]])
        lines.append({"solver": solver, "same_code": same_code, **answers, **_times(rows)})
    frame = pd.DataFrame(lines)
    return frame.assign(right_p=holm(frame["right_p"]))


def _answers(answerable: pd.DataFrame) -> dict[str, object]:
    """How one solver's answers changed.

    The questions have a path. `right_p` is not corrected yet, and NaN without questions.
    """
    # costs of the sign test: the share of wrong repeats
    test = sign_test(1 - answerable["right_new"], 1 - answerable["right_base"])
    p = test.p
    if not test.pairs:
        p = np.nan
    # the opposite of `lost`
    gained = answerable["right_base"].eq(0) & answerable["right_new"].eq(1)
    return {
        "questions": len(answerable),
        "right_base": answerable["right_base"].mean(),
        "right_new": answerable["right_new"].mean(),
        "right_p": p,
        "lost": int(lost(answerable).sum()),
        "gained": int(gained.sum()),
    }


def lost(pairs: pd.DataFrame) -> Mask:
    """A mask of the questions that were lost.

    A lost question was right in every repeat of the base and in no repeat of the new run.
    """
    return pairs["right_base"].eq(1) & pairs["right_new"].eq(0)


def newly_false(pairs: pd.DataFrame) -> Mask:
    """A mask of questions with a new false claim.

    The claim or bound is false in the new run only.
    """
    return pairs["false_new"] & ~pairs["false_base"]


def less_accurate(pairs: pd.DataFrame) -> Mask:
    """A mask of right answers that became less accurate.

    The question is right in both runs, and the new gap is more than `WORSE_GAP` times the old one.
    An old gap counts as at least `GAP_FLOOR`.
    """
    before = pairs["gap_base"].clip(lower=GAP_FLOOR)
    return _right_in_both(pairs) & (pairs["gap_new"] > WORSE_GAP * before)


def _right_in_both(pairs: pd.DataFrame) -> Mask:
    """A mask of questions right in both runs.

    Such a question has an answer, and all repeats of both runs are right.
    """
    return pairs["answerable"] & pairs["right_base"].eq(1) & pairs["right_new"].eq(1)


def _times(pairs: pd.DataFrame) -> dict[str, object]:
    """Mean times (s) of both runs, and their ratio.

    Only questions that are right in both runs count. Keys: timed (their number), time_base,
    time_new, and those of `TIME_RATIO`.
    """
    comparable = pairs[_right_in_both(pairs) & pairs["time_base"].gt(0) & pairs["time_new"].gt(0)]
    times = comparable.set_index("scenario_id")[["time_base", "time_new"]]
    means = np.exp(np.log(times).mean())
    ratio = bootstrap(times, geometric_means(0.0), "time_base").loc["time_new"]
    interval = ratio[["estimate", "low", "high"]]
    return {"timed": len(times), **means, **dict(zip(TIME_RATIO, interval, strict=True))}
