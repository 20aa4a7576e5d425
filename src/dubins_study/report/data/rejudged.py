"""Judge rows of another set-up anew.

The check reads their controls when the rows are read.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any, NamedTuple

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
    shared = one.versions.keys() & other.versions.keys()
    alike = all(one.versions[name] == other.versions[name] for name in shared)
    return one.machine == other.machine and alike


def judged_anew(rows: pa.Table, manifest: Manifest) -> tuple[pa.Table, Recheck]:
    """The rows judged anew, and the differences.

    The differences are those from the folder's verdicts. An attempt that did not return has the
    verdict `none`. Questions that a solver does not take, and convex problems, stay as they are.
    """
    records = rows.to_pylist()
    left = sum(row["branch"] in BRANCHES_WITHOUT_PATH for row in records)
    new_values = {
        place: _checked(row, manifest)
        for place, row in enumerate(records)
        if row["branch"] not in BRANCHES_WITHOUT_PATH and row["outcome"] != UNTAKEN
    }
    changed = 0
    differing: Counter[str] = Counter()
    for place, new in new_values.items():
        columns = [name for name in _NAMED if not _agree(records[place][name], new[name])]
        changed += bool(columns)
        differing.update(columns)
    for name in _CHECKED:
        values = [new_values.get(place, row)[name] for place, row in enumerate(records)]
        field = rows.schema.field(name)
        rows = rows.set_column(
            rows.schema.get_field_index(name), field, pa.array(values, field.type)
        )
    counts = {name: differing[name] for name in _NAMED if differing[name]}
    return rows, Recheck(len(new_values), left, changed, counts)


def _checked(row: Mapping[str, Any], manifest: Manifest) -> dict[str, Any]:
    """The columns that the check fills.

    It judges a row's controls and claim.
    """
    scenario = scenario_of(row)
    branch = row["branch"]
    usual = PROFILES.get(row["profile"], PROFILES["default"])
    limit = usual.search_s
    if not is_missing(row["limit_s"]):
        limit = min(row["limit_s"], limit)
    allowed = replace(usual, gap=manifest.gap_tolerance, search_s=limit)
    path = None
    claim = Claim.NONE
    if row["outcome"] == "returned":
        claim = Claim(row["claim"])
        if row["curvatures"] is not None:
            path = Path(start_of(row), row["curvatures"], row["lengths"])
    judgement = judge(scenario, path, claim, branch, allowed)
    multipliers = None
    stated = row["multiplier_x"], row["multiplier_y"]
    if not any(map(is_missing, stated)):
        multipliers = stated
    certificate = certify(
        scenario,
        path,
        judgement,
        branch,
        lower_bound=row["lower_bound"],
        multipliers=multipliers,
        tolerances=allowed,
    )
    values = vars(judgement) | vars(certificate)
    if row["presolved"]:
        values["proof"] = Proof.NONE
    known = {name: value for name, value in values.items() if not is_missing(value)}
    return {name: known.get(name) for name in _CHECKED}


def _agree(stored: Any, new: Any) -> bool:
    if stored is None or new is None or isinstance(new, str | bool):
        return bool(stored == new)
    return bool(abs(stored - new) <= _ABSOLUTE + _RELATIVE * abs(new))
