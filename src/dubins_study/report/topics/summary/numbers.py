"""How often each solver is right."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.elements.shares import with_share
from dubins_study.report.statistics.methods import methods_of


def summary(verdicts: pd.DataFrame, methods: pd.DataFrame) -> pd.DataFrame:
    """One row per solver: verdicts, false claims, wrong basins and times where a path exists.

    Solvers that were asked no such question are left out, unless none was.

    Args:
        verdicts: from `report.data.verdicts.verdicts`.
        methods: from `report.data.verdicts.methods`.

    Returns:
        The columns of both, those of `methods_of`, and those of `with_share` for `right`, a share
        of the questions; in the order of `methods_of`.
    """
    asked = verdicts["questions"] > 0
    counted = verdicts[asked] if asked.any() else verdicts
    frame = with_share(counted, "right", counted["right"], counted["questions"])
    named = methods_of(methods[methods["solver"].isin(counted["solver"])])
    return named.join(frame.set_index("solver")).reset_index()
