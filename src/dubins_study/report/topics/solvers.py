"""The section that says what each solver's short name stands for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import Column, columns
from dubins_study.report.elements.content import General, Section, Table, Topic
from dubins_study.report.elements.formats import some
from dubins_study.report.elements.looks import names_of
from dubins_study.report.statistics.metrics import parse_spec

_COLUMNS = (
    *columns(kind="text", label="solver"),
    Column("solver", "spec", kind="code"),
    *columns(kind="prose", given="settings that are not the default"),
    *columns(kind="prose", defaults="settings at their default"),
)


def solvers_section(results: Results) -> Section | None:
    """Every solver's short name, spec and settings."""
    names = names_of(results)
    names = names[names.index.isin(results.attempts.values("solver"))]
    if names.empty:
        return None
    frame = names.reset_index(names="solver")
    parts = [_settings(spec, results.settings.get(spec, {})) for spec in frame["solver"]]
    frame = frame.join(pd.DataFrame(parts, columns=["given", "defaults"]))
    caption = (
        "Short names and specs. A spec names the settings that are not the default; the solver's "
        "manifest has the others. Its hash and the versions of its packages stand under Provenance."
    )
    numbers = ("formulation", "engine", "guess")
    return Section(
        "solvers",
        "Solvers and their settings",
        f"{some(len(frame), 'solver')}: a short name says the engine, the formulation, the initial "
        "guess if it is not the usual one, and the settings by which solvers of the page differ. "
        "It is the same in all figures and tables, whose CSV files hold the spec.",
        (Table("solvers", caption, frame, _COLUMNS, numbers=numbers),),
        lead="Look up here what a short name stands for, and copy the spec into a command.",
    )


def _settings(spec: str, settings: Mapping[str, Any]) -> tuple[str, str]:
    """The settings of a spec, and those that it leaves at their default."""
    given = parse_spec(spec)[1]
    rest = {key: value for key, value in settings.items() if key not in given}
    return _listed(given), _listed(rest)


def _listed(settings: Mapping[str, Any]) -> str:
    return ", ".join(f"{key} {_text(value)}" for key, value in settings.items())


def _text(value: Any) -> str:
    return {"True": "yes", "False": "no"}.get(str(value), str(value))


TOPIC = Topic("the solvers and their settings", solvers_section, General.EVERY)
