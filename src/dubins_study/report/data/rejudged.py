"""Judge rows of another set-up anew.

The check reads their controls when the rows are read.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any, NamedTuple

import pandas as pd
import pyarrow as pa

from dubins_study.report.data.attempts import UNTAKEN
from dubins_study.study.judging.certify import certify
from dubins_study.study.judging.judge import judge
from dubins_study.study.kinds.table import BRANCHES_WITHOUT_PATH
from dubins_study.study.path import Path
from dubins_study.study.rows.manifest import Manifest
from dubins_study.study.rows.parts import start_of
from dubins_study.study.rows.schema import Certificate, Judgement
from dubins_study.study.scenario_frame import is_missing, scenario_of
from dubins_study.study.tolerances import PROFILES
from dubins_study.study.words import Claim, Proof

# Smaller differences are rounding: sines of other libraries may change the last digits.
_RELATIVE = 1e-6
_ABSOLUTE = 1e-9
# The compared columns; the others follow from them.
_NAMED = ("verdict", "false_claim", "wrong_basin", "proof", "false_bound", "length", "gap", "miss")
# Columns of convex problems only, whose answers are not in the rows.
_CONVEX = ("dual_residual", "duality_gap", "certified_gap")
_CHECKED = [f.name for f in (*fields(Judgement), *fields(Certificate)) if f.name not in _CONVEX]


class Recheck(NamedTuple):
    """Numbers of rows that were judged anew.

    It also counts the rows that were not, and the differences.
    """

    judged: int
    left: int  # answers to convex problems, which rows do not hold
    changed: int  # rows of which something differs
    differing: dict[str, int]  # column -> rows in which it differs from what the folder says


def same_set_up(one: Manifest, other: Manifest) -> bool:
    """Whether two folders' runs had one set-up.

    One machine, and one version of each package of both.
    """
    both = one.versions.keys() & other.versions.keys()
    alike = all(one.versions[name] == other.versions[name] for name in both)
    return one.machine == other.machine and alike


def judged_anew(rows: pa.Table, manifest: Manifest) -> tuple[pa.Table, Recheck]:
    """The rows judged anew, and the differences.

    The differences are those from the folder's verdicts. An attempt that did not return has the
    verdict `none`. Questions that a solver does not take, and convex problems, stay as they are.
    """
    records = rows.to_pylist()
    left = sum(row["branch"] in BRANCHES_WITHOUT_PATH for row in records)
    asked = [
        place
        for place, row in enumerate(records)
        if row["branch"] not in BRANCHES_WITHOUT_PATH and row["outcome"] != UNTAKEN
    ]
    new_values = {place: _checked(records[place], manifest) for place in asked}
    differs = pd.DataFrame(
        [
            {name: not _agree(records[place][name], new[name]) for name in _NAMED}
            for place, new in new_values.items()
        ],
        columns=list(_NAMED),
        dtype=bool,
    )
    for name in _CHECKED:
        values = [new_values.get(place, row)[name] for place, row in enumerate(records)]
        field = rows.schema.field(name)
        rows = rows.set_column(
            rows.schema.get_field_index(name), field, pa.array(values, field.type)
        )
    counts = {name: int(differs[name].sum()) for name in _NAMED if differs[name].any()}
    changed = int(differs.any(axis=1).sum())
    return rows, Recheck(len(asked), left, changed, counts)


def _checked(row: Mapping[str, Any], manifest: Manifest) -> dict[str, Any]:
    """The columns that the check fills.

    It judges a row's controls and claim.
    """
    scenario = scenario_of(row)
    branch = row["branch"]
    usual = PROFILES.get(row["profile"], PROFILES["default"])
    limit = usual.search_s if is_missing(row["limit_s"]) else min(row["limit_s"], usual.search_s)
    allowed = replace(usual, gap=manifest.gap_tolerance, search_s=limit)
    path = None
    if row["outcome"] == "returned" and row["curvatures"] is not None:
        path = Path(start_of(row), row["curvatures"], row["lengths"])
    claim = Claim(row["claim"]) if row["outcome"] == "returned" else Claim.NONE
    judgement = judge(scenario, path, claim, branch, allowed)
    both = row["multiplier_x"], row["multiplier_y"]
    certificate = certify(
        *(scenario, path, judgement, branch),
        lower_bound=row["lower_bound"],
        multipliers=None if any(map(is_missing, both)) else both,
        tolerances=allowed,
    )
    values = vars(judgement) | vars(certificate)
    if row["presolved"]:
        values["proof"] = Proof.NONE
    return {name: None if is_missing(values[name]) else values[name] for name in _CHECKED}


def _agree(stored: Any, new: Any) -> bool:
    if stored is None or new is None or isinstance(new, str | bool):
        return bool(stored == new)
    return bool(abs(stored - new) <= _ABSOLUTE + _RELATIVE * abs(new))
