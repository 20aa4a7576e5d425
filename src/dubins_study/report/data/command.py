"""The commands that ask a row's question again, or all questions of a run."""

from __future__ import annotations

import math
import shlex
from collections.abc import Hashable, Mapping
from typing import Any

import pandas as pd

from dubins_study.study.rows.manifest import Manifest
from dubins_study.study.scenario import VIA
from dubins_study.study.scenario_frame import is_missing, numbers_of

SCENARIO = ("x", "y", "heading", "target_x", "target_y", "radius")
ROUTE = (*VIA, "final_heading")


def solve_command(row: Mapping[Hashable, Any] | pd.Series) -> str:
    """The `dubins-study solve` command of a row; numbers with all their digits, quoted for a shell.

    It states the profile and `time_limit_s` if the row has them.
    """
    x, y, heading, target_x, target_y, radius = (number_text(row[name]) for name in SCENARIO)
    parts = ["dubins-study solve"]
    if abs(float(heading)) > 2 * math.pi:  # which needs a unit
        heading += "rad"
    parts += [f"--from {x} {y} {heading}"] if (x, y, heading) != ("0", "0", "0") else []
    via = [numbers_of(name, row.get(name)) or () for name in VIA]
    parts += [f"--via {number_text(u)} {number_text(v)}" for u, v in zip(*via, strict=True)]
    if not is_missing(final := row.get("final_heading")):
        parts.append(f"--final-heading {number_text(final)}rad")
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


# Options of a run that say who answers its questions, and how many at once: with their values.
_OF_ANSWERS = ("--solver", "--jobs", "--engine")


def run_command(manifest: Manifest, options: str) -> str:
    """The `dubins-study run` command that asks a folder's questions of other solvers.

    The folder's own command names its experiment's file, or its file of scenarios, which the
    experiment's name does not; the name stands where there is no such command. The `options` are
    appended as a shell reads them.
    """
    words = _asked_words(manifest.command) or [manifest.experiment.name]
    return f"dubins-study run {shlex.join(words)} {options}"


def _asked_words(command: str) -> list[str]:
    """The words of a run's command that say what it asks; none of a text that is no such command.

    >>> _asked_words("dubins-study run --scenarios 'my s.csv' --solver ipopt --jobs 2 --repeats 3")
    ['--scenarios', 'my s.csv', '--repeats', '3']
    """
    try:
        words = shlex.split(command)
    except ValueError:  # a quotation without an end
        return []
    if words[:2] != ["dubins-study", "run"]:
        return []
    before = ["", *words]
    pairs = zip(words[2:], before[2:], strict=False)
    return [word for word, last in pairs if not {word, last} & set(_OF_ANSWERS)]
