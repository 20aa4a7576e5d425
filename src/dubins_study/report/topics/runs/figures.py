"""How steady the machines of the runs were."""

from __future__ import annotations

import pandas as pd
from matplotlib.axes import Axes

from dubins_study.study.rows.machine_noise import NOISY


def plot_probes(ax: Axes, ratios: pd.DataFrame) -> None:
    """What the calibration probe took, relative to its median, against time.

    Columns: run (its name), when (s since the run began), ratio.
    """
    for name, group in ratios.groupby("run", sort=False):
        ax.plot(group["when"], group["ratio"], lw=0.8, label=str(name))
    ax.axhspan(1 - NOISY / 2, 1 + NOISY / 2, alpha=0.15, lw=0)
    ax.set(xlabel="time since the run began (s)", ylabel="probe / its median")
