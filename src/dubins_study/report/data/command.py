"""The command that asks a row's question again."""

from __future__ import annotations

import shlex
from collections.abc import Hashable, Mapping
from typing import Any

import pandas as pd

SCENARIO = ("x", "y", "heading", "target_x", "target_y", "radius")


def solve_command(row: Mapping[Hashable, Any] | pd.Series) -> str:
    """The `dubins-study solve` command of a row; numbers with all their digits, quoted for a shell.

    Args:
        row: the columns of a scenario, branch, solver, and, if it has them, profile and
            `time_limit_s`, which the command then states.
    """
    x, y, heading, target_x, target_y, radius = (number_text(row[name]) for name in SCENARIO)
    parts = ["dubins-study solve"]
    parts += [f"--from {x} {y} {heading}"] if (x, y, heading) != ("0", "0", "0") else []
    parts += [f"--radius {radius}"] if radius != "1" else []
    parts += [f"--branch {shlex.quote(str(row['branch']))}"] if row["branch"] != "best" else []
    profile = str(row.get("profile", "default"))
    parts += [f"--profile {shlex.quote(profile)}"] if profile != "default" else []
    limit = row.get("time_limit_s")
    parts += [f"--time-limit {number_text(limit)}"] if limit is not None else []
    # without the dashes a negative number would be read as an option
    parts += [f"--solver {shlex.quote(str(row['solver']))} -- {target_x} {target_y}"]
    return " ".join(parts)


def number_text(value: object) -> str:
    """A number that reads back as the same double; a whole one without its `.0`."""
    return repr(float(str(value))).removesuffix(".0")
