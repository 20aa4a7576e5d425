"""How often each solver is right."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.elements.shares import with_share
from dubins_study.report.statistics.methods import by_method


def summary(verdicts: pd.DataFrame, methods: pd.DataFrame) -> pd.DataFrame:
    """One row per solver: verdicts, false claims, wrong basins and times where a path exists.

    Args:
        verdicts: from `report.data.verdicts.verdicts`.
        methods: from `report.data.verdicts.methods`.

    Returns:
        The columns of both, and those of `with_share` for `right`, a share of the questions.
    """
    frame = with_share(verdicts, "right", verdicts["right"], verdicts["questions"])
    return by_method(frame.merge(methods, on="solver", validate="one_to_one"))
