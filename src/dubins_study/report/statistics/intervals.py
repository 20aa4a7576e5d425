"""Intervals of shares."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import NormalDist
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from dubins_study.study.path import FloatArray


class Share(NamedTuple):
    """A share and its interval.

    `successes` of `trials` (a sum of shares may be fractional), `share` of them (NaN if there are
    no trials), and the ends of its interval, `low` and `high`.
    """

    successes: float
    trials: int
    share: float
    low: float
    high: float


def wilson_intervals(successes: ArrayLike, trials: ArrayLike, level: float = 0.95) -> FloatArray:
    """Wilson's score intervals of shares k / n.

    The ends are the shares p with |k/n - p| = z sqrt(p (1 - p) / n), z the normal quantile of
    (1 + level) / 2:

        (k + z^2 / 2  -+  z sqrt(k (n - k) / n + z^2 / 4)) / (n + z^2)

    (Wilson 1927, "Probable inference, the law of succession, and statistical inference", J. Am.
    Stat. Assoc. 22; recommended by Brown, Cai and DasGupta 2001, "Interval estimation for a
    binomial proportion", Stat. Sci. 16, sec. 3). Trials must be independent: count scenarios, not
    the repeats of one. k may be a sum of shares in [0, 1], e.g. of the success rates of scenarios
    over their repeats: their variance is at most p (1 - p), so that the interval is, if anything,
    too wide. Of no trials nothing is known: the interval is (0, 1), which the formula tends to.

    Args:
        successes: k, any shape that broadcasts with `trials`.
        trials: n.
        level: confidence level, in (0, 1).
    Returns:
        The shape of k / n and a last axis of 2: low, high. Shares.
    Raises:
        ValueError: if `level` is outside (0, 1), or k and n are not finite with 0 <= k <= n.
    """
    z = NormalDist().inv_cdf((1 + checked_level(level)) / 2)
    k, n = np.broadcast_arrays(
        np.asarray(successes, dtype=np.float64), np.asarray(trials, dtype=np.float64)
    )
    wrong = ~(np.isfinite(n) & (k >= 0) & (k <= n))
    if wrong.any():
        raise ValueError(
            f"{k[wrong][0]:g} successes of {n[wrong][0]:g} trials: successes are between 0 and the "
            "trials"
        )
    variance = k * (n - k) / np.where(n > 0, n, 1.0)
    half = z * np.sqrt(variance + z * z / 4)
    low, high = (k + z * z / 2 - half) / (n + z * z), (k + z * z / 2 + half) / (n + z * z)
    # With successes alone the upper end is 1, but for rounding.
    return np.stack([low, np.where(k < n, high, 1.0)], axis=-1)


def wilson_interval(successes: float, trials: float, level: float = 0.95) -> tuple[float, float]:
    """Wilson's score interval of one share; see `wilson_intervals`."""
    low, high = wilson_intervals(successes, trials, level)
    return float(low), float(high)


def checked_level(level: float) -> float:
    """The confidence level, if it is one."""
    if not 0 < level < 1:
        raise ValueError(f"confidence level {level!r}: a level is between 0 and 1, e.g. 0.95")
    return level


def scenario_share(success: pd.Series, scenario: pd.Series, level: float = 0.95) -> Share:
    """The share of successes with its interval; repeats of one scenario count as one trial.

    The share is the mean over scenarios of each scenario's success rate, the interval Wilson's for
    as many trials as there are scenarios (see `wilson_intervals` on fractional successes).

    Args:
        success: whether each attempt succeeded, shape (m,).
        scenario: the scenario of each attempt, shape (m,), with the index of `success`.
        level: confidence level, in (0, 1).
    """
    rates = success.astype(np.float64).groupby(scenario, observed=True, dropna=False).mean()
    trials = len(rates)
    k = min(float(rates.sum()), trials)  # a sum of shares may exceed their number by rounding
    return Share(
        k, trials, k / trials if trials else float("nan"), *wilson_interval(k, trials, level)
    )


def scenario_shares(
    rows: pd.DataFrame,
    *,
    by: Sequence[str],
    success: str,
    scenario: Sequence[str],
    level: float = 0.95,
) -> pd.DataFrame:
    """`scenario_share` of every group of attempts.

    Args:
        rows: one row per attempt.
        by: names of the columns that make a group, e.g. solver and region.
        success: name of the column that says whether an attempt succeeded.
        scenario: names of the columns that tell scenarios apart.
        level: confidence level, in (0, 1).
    Returns:
        Indexed by `by`; columns successes, trials, share, low, high, as in `Share`.
    """
    keys = [*by, *(name for name in scenario if name not in by)]
    rates = (
        rows[success]
        .astype(np.float64)
        .groupby([rows[key] for key in keys], observed=True, dropna=False)
    )
    groups = rates.mean().groupby(level=list(range(len(by))), observed=True, dropna=False)
    frame = pd.DataFrame({"successes": groups.sum(), "trials": groups.size()})
    frame["successes"] = frame["successes"].clip(upper=frame["trials"])
    frame["share"] = frame["successes"] / frame["trials"]
    ends = wilson_intervals(frame["successes"], frame["trials"], level)
    return frame.assign(low=ends[:, 0], high=ends[:, 1])
