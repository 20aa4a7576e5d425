"""The last sections: solvers, runs, and limits.

The section of limits has the data dictionary, with the meaning of every column of the rows.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import pandas as pd

from dubins_study.report.data.results import Folder, Results
from dubins_study.report.elements.columns import Column, columns, marks
from dubins_study.report.elements.content import General, Section, Table, Topic
from dubins_study.report.elements.formats import seconds, share, some
from dubins_study.report.elements.looks import names_of
from dubins_study.report.statistics.metrics import parse_spec
from dubins_study.study.rows.manifest import NOISY
from dubins_study.study.rows.schema import ROW, VERSION

_SOLVERS = (
    *columns(kind="text", label="solver"),
    Column("solver", "spec", kind="code"),
    *columns(kind="prose", given="settings that are not the default"),
    *columns(kind="prose", defaults="settings at their default"),
)


def solvers_section(results: Results) -> Section | None:
    """The section with solvers' names, specs and settings."""
    names = names_of(results)
    if names.empty:
        return None
    frame = names.reset_index(names="solver")
    settings_of = results.settings
    stated_texts = []
    default_texts = []
    for spec in frame["solver"]:
        stated = parse_spec(spec)[1]
        every = settings_of.get(spec, {})
        defaults = {name: value for name, value in every.items() if name not in stated}
        stated_texts.append(_listed(stated))
        default_texts.append(_listed(defaults))
    frame["given"] = stated_texts
    frame["defaults"] = default_texts
    caption = (
        "Short names and specs. A spec names the settings that are not the default; the solver's "
        "manifest has the others. Provenance has its hash and the versions of its packages."
    )
    numbers = ("formulation", "engine", "guess")
    return Section(
        "solvers",
        "Solvers and their settings",
        f"{some(len(frame), 'solver')}. A short name has the engine and the formulation. It has "
        "the initial guess if that is unusual, and the settings by which solvers of the page "
        "differ. All figures and tables use the same names; their CSV files have the spec.",
        (Table("solvers", caption, frame, _SOLVERS, numbers=numbers),),
        lead="Look up here what a short name stands for, and copy the spec into a command.",
    )


def _listed(settings: Mapping[str, Any]) -> str:
    """Settings as text: `n 50, presolve yes`."""
    texts = {"True": "yes", "False": "no"}
    return ", ".join(f"{key} {texts.get(str(value), value)}" for key, value in settings.items())


def runs(folders: Iterable[Folder]) -> pd.DataFrame:
    """One row per run, in the folders' order.

    `load` is a text: the average load of the last minute, at the run's start and at its end.
    `spread` is a share. Unknown seconds and an unknown spread are NaN.
    """
    lines: list[dict[str, Any]] = []
    for folder in folders:
        for run in folder.manifest.runs:
            duration = run.seconds
            state = run.state
            if state == "running":
                # The entry of a killed run stays so; its seconds say nothing of its end.
                duration = None
                state = "running, or killed"
            line = {
                "experiment": folder.name,
                "run": run.run_id,
                "started": run.started,
                "seconds": _number(duration),
                "state": state,
                "executor": run.executor,
                "jobs": str(run.jobs),
                "where": f"{_machine(run.machine)}; governor {run.governor}",
                "load": f"{_load(run.load_start)} to {_load(run.load_end)}",
                "spread": _number(run.spread),
            }
            lines.append(line)
    return pd.DataFrame(lines)


def _number(value: float | None) -> float:
    """The number, or NaN for None."""
    if value is None:
        return math.nan
    return value


def _machine(machine: Mapping[str, Any]) -> str:
    """A machine as text: processor, system, memory, cores."""
    texts = [str(machine[key]) for key in ("processor", "system", "memory") if key in machine]
    if "cores" in machine:
        texts.append(f"{machine.get('usable_cores', machine['cores'])} of {machine['cores']} cores")
    return ", ".join(texts)


def _load(averages: Sequence[float] | None) -> str:
    """The average load over the last minute as text.

    A question mark stands for an unknown load.
    """
    if not averages:
        return "?"
    return f"{averages[0]:.2f}"


def runs_section(results: Results) -> Section | None:
    """The section with the table of runs."""
    frame = runs(results.folders)
    if frame.empty:
        return None
    text = (
        "During a run its worker processes time a small fixed piece of work every couple of "
        "seconds. Varied by: from the 5th to the 95th percentile of these times, over the median. "
        "Smaller differences in time mean nothing. A dash: the run was too short to tell."
    )
    shown = (
        *columns(kind="code", experiment="experiment", run="run"),
        *columns(_minute, kind="text", started="started (UTC)"),
        *columns(seconds, seconds="took"),
        *columns(kind="text", state="state", executor="executor"),
        *columns(jobs="jobs"),
        *columns(share, spread="varied by"),
        *columns(kind="text", load="load"),
        *columns(kind="prose", where="machine"),
    )
    caption = (
        "Every run that wrote into these folders. Load: processes that wanted a core in the last "
        "minute, at the start and at the end. The governor sets the cores' clock. Varied by more "
        f"than {share(NOISY)} is marked."
    )
    table = Table("runs", caption, frame, shown, marks(frame[["spread"]] > NOISY, "spread"))
    lead = "Check here that a machine was steady before you quote its times."
    return Section("runs", "The runs and their machines", text, (table,), lead)


def _minute(started: str) -> str:
    """A time in ISO 8601 as `2026-01-31 12:34`."""
    return started[:16].replace("T", " ")


# (the subject of the numbers, and the limit that follows from it)
_LIMITS = (
    (
        "One problem: to a point, perhaps through others, with any or a given heading at the end. "
        "Forward, at constant speed and known radius, without obstacles and wind.",
        "How formulations and engines do on other problems.",
    ),
    (
        "Scenarios chosen to cover all cases, also the difficult ones; each counts once.",
        "How often a method is right in practice, where easy targets may be the rule.",
    ),
    (
        "Engines as Python calls them, at the settings that the solvers' table names.",
        "How fast an engine is from another language, or how good it is with tuned settings.",
    ),
    (
        "One kind of machine per run, one thread per engine, versions as under Provenance.",
        "Times on other machines. With other versions verdicts may change too.",
    ),
    (
        "Verdicts against the closed form, and for routes a search, which this package derives.",
        "That the closed form is right. The package's tests compare it with independent "
        "searches, and the certificates prove answers from their controls alone.",
    ),
)


def limits_section(_: Results | None) -> Section:
    """The section on limits, with the data dictionary."""
    lead = "On the left: what the numbers of this page measure. On the right: what they do not say."
    text = (
        "Below is the data dictionary: every column of the rows in a results folder's Parquet "
        f"files, schema {VERSION}."
    )
    frame = pd.DataFrame(_LIMITS, columns=["numbers", "unknown"])
    sides = columns(kind="prose", numbers="the numbers are of", unknown="they do not say")
    limits = Table("limits", "Limits of the whole page.", frame, sides, stacked=True)
    shown = (
        *columns(kind="code", name="column"),
        *columns(kind="text", type="type", unit="unit"),
        *columns(kind="prose", meaning="meaning"),
    )
    caption = (
        "The columns of the rows. Missing and non-finite numbers are null; a unit of 1 is a share "
        "or a ratio."
    )
    frame = pd.DataFrame(ROW, columns=list(ROW[0]._fields))
    tables = limits, Table("columns", caption, frame, shown)
    return Section("limits", "Limits and data dictionary", text, tables, lead)


SOLVERS_TOPIC = Topic("the solvers and their settings", solvers_section, General.EVERY)
RUNS_TOPIC = Topic("the runs and their machines", runs_section, General.EVERY)
TOPIC = Topic("limits", limits_section, General.EVERY)
