"""What two runs differ in besides their answers: machine, limits, packages, code."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.study.rows.manifest import Manifest

_NOTHING = "–"


def differences(base: Results, new: Results) -> pd.DataFrame:
    """What the manifests of two runs do not share.

    Returns:
        Columns what, base, new (as text), and solvers: how many of the solvers in both runs it is
        about; NaN if it is about the run.
    """
    sides = [results.folders[0].manifest for results in (base, new)]
    lines = [*_of_runs(*sides), *_of_solvers(*sides)]
    return pd.DataFrame(lines, columns=["what", "base", "new", "solvers"])


def _of_runs(base: Manifest, new: Manifest) -> Iterator[tuple[str, str, str, float]]:
    plain = ("profile", "time_limit_s", "memory_limit_gib", "gap_tolerance")
    before, after = (
        {name.replace("_", " "): getattr(each, name) for name in plain}
        | {f"machine: {key}": value for key, value in each.machine.items()}
        | {f"version of {key}": value for key, value in each.versions.items()}
        | {"git commit": each.git.get("commit"), "jobs": _jobs(each)}
        for each in (base, new)
    )
    for what in dict.fromkeys([*before, *after]):
        if before.get(what) != after.get(what):
            yield what, _text(before.get(what)), _text(after.get(what)), float("nan")


def _jobs(manifest: Manifest) -> str:
    return ", ".join(map(str, sorted({run.jobs for run in manifest.runs})))


def _of_solvers(base: Manifest, new: Manifest) -> Iterator[tuple[str, str, str, float]]:
    """Packages with their versions, one line each; code and settings, one line for all solvers."""
    both = [spec for spec in base.solvers if spec in new.solvers]
    changed: dict[tuple[str, str, str], int] = {}
    for spec in both:
        before, after = base.solvers[spec], new.solvers[spec]
        pairs = [
            (f"package {name}", before.packages.get(name), after.packages.get(name))
            for name in dict.fromkeys([*before.packages, *after.packages])
        ]
        if before.settings != after.settings:
            pairs.append((f"settings of {spec}", before.settings, after.settings))
        for what, old, newer in pairs:
            if old != newer:
                line = (what, _text(old), _text(newer))
                changed[line] = changed.get(line, 0) + 1
    for line, number in changed.items():
        yield *line, float(number)
    code = sum(base.solvers[spec].code_digest != new.solvers[spec].code_digest for spec in both)
    if code:
        yield "code of solvers, settings or packages", "one digest", "another", float(code)


def _text(value: Any) -> str:
    return _NOTHING if value is None or value == "" else str(value)
