"""Judge the rows of another set-up again.

The check runs on the stored controls while the report reads the rows.
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
    """The counts of rows that were judged again."""

    judged: int
    left: int  # answers to convex problems, which rows do not hold
    changed: int  # rows of which something differs
    differing: dict[str, int]  # column -> rows in which it differs from what the folder says


def same_set_up(one: Manifest, other: Manifest) -> bool:
    """Whether the runs of two folders had one set-up.

    One set-up is one machine, and equal versions of the packages that both manifests name.
    """
    shared = one.versions.keys() & other.versions.keys()
    alike = all(one.versions[name] == other.versions[name] for name in shared)
    return one.machine == other.machine and alike


def judged_anew(rows: pa.Table, manifest: Manifest) -> tuple[pa.Table, Recheck]:
    """Judge rows again; return the new rows and `Recheck`.

    The rows come back with new values in the columns of `Judgement` and `Certificate`. `Recheck`
    counts where these differ from the folder's. An attempt that did not return is judged as without
    a path. Two kinds of rows are not judged and keep their values: questions that a solver does not
    take, and convex problems.
    """
    records = rows.to_pylist()
    left = sum(row["branch"] in BRANCHES_WITHOUT_PATH for row in records)
    new_values = {
        place: _checked(row, manifest)
        for place, row in enumerate(records)
        if row["branch"] not in BRANCHES_WITHOUT_PATH and row["outcome"] != UNTAKEN
    }  # place of the row -> its judged columns
    changed = 0
    differing: Counter[str] = Counter()
    for place, new in new_values.items():
        columns = [name for name in _NAMED if not _agree(records[place][name], new[name])]
        changed += bool(columns)
        differing.update(columns)
    for name in _CHECKED:  # a row that was not judged keeps its stored value
        values = [new_values.get(place, row)[name] for place, row in enumerate(records)]
        field = rows.schema.field(name)
        rows = rows.set_column(
            rows.schema.get_field_index(name), field, pa.array(values, field.type)
        )
    counts = {name: differing[name] for name in _NAMED if differing[name]}
    return rows, Recheck(len(new_values), left, changed, counts)


def _checked(row: Mapping[str, Any], manifest: Manifest) -> dict[str, Any]:
    """The judged columns of a row, by name.

    The check judges the row's controls and claim. A missing value is None.
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
    if row["presolved"]:  # no engine has proved anything, whatever the check finds
        values["proof"] = Proof.NONE
    known = {name: value for name, value in values.items() if not is_missing(value)}
    return {name: known.get(name) for name in _CHECKED}


def _agree(stored: Any, new: Any) -> bool:
    """Whether two values agree; numbers may differ by rounding."""
    if stored is None or new is None or isinstance(new, str | bool):
        return bool(stored == new)
    return bool(abs(stored - new) <= _ABSOLUTE + _RELATIVE * abs(new))
