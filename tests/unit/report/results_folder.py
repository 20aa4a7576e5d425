"""Small results folders, written as a run writes them."""

import json
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from dubins_study.experiments.definition.experiment import packaged, read
from dubins_study.report.data.results import load as load_folders
from dubins_study.solvers.registry import SolverError, load, settings
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.judging.judge import judge
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import ROW, VERSION, arrow_schema
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim
from tests.cases import PAPER, scenario_row

SCHEMA = arrow_schema()


def paper_scenarios() -> list[Scenario]:
    return [replace(scenario, label=label) for label, scenario in PAPER.items()]


def attempt(
    scenario: Scenario,
    solver: str = "analytic",
    branch: str = "best",
    path: Path | str | None = "exact",
    claim: Claim = Claim.OPTIMAL,
    **changes: Any,
) -> dict[str, Any]:
    """One judged row.

    `path` is the closed form's unless given.
    """
    given = shortest_path(scenario, branch) if isinstance(path, str) else path
    if given is None and claim is Claim.OPTIMAL:
        claim = Claim.INFEASIBLE
    judgement = judge(scenario, given, claim, branch)
    row: dict[str, Any] = {column.name: None for column in ROW}
    row |= scenario_row(scenario)
    row |= vars(judgement)
    row |= {
        "scenario_id": f"{hash((scenario.target_x, scenario.target_y, scenario.radius)):x}",
        "solver": solver,
        "profile": "default",
        "branch": branch,
        "initial_guess": "cold",
        "repeat": 0,
        "code_digest": "0123456789ab",
        "outcome": "returned",
        "claim": str(claim),
        "native_status": "",
        "message": "",
        "curvatures": None if given is None else given.curvatures.tolist(),
        "lengths": None if given is None else given.lengths.tolist(),
        "build_s": 1e-4,
        "solve_s": 2e-3,
        "wall_s": 2.1e-3,
        "iterations": 7,
        "formulation": "one NLP a word",
        "engine": solver.partition("[")[0],
        "guess": "bearing",
        "versions": "{}",
        "machine": "Linux x86_64",
        "threads": 1,
        "jobs": 1,
        "executor": "local",
        "run_id": "a",
        "started": "2026-01-01T00:00:00Z",
    }
    return row | changes


def astray(scenario: Scenario, length: float = 1.0) -> Path:
    """A straight path that leads nowhere."""
    return Path(scenario.start, [0.0], [length])


_MEASURED = ("region", "margin", "reference_word", "reference", "length", "gap", "miss")
_MEASURED += ("build_s", "solve_s", "wall_s", "iterations")


def lost(scenario: Scenario, solver: str = "x", **changes: Any) -> dict[str, Any]:
    """The row of a process that crashed."""
    gone: dict[str, Any] = dict.fromkeys(_MEASURED)
    gone |= {"path": None, "claim": Claim.NONE, "outcome": "crashed"}
    return attempt(scenario, solver, **(gone | changes))


def compared_row(question: int, solver: str, **changes: Any) -> dict[str, Any]:
    """A right answer for the comparison of methods.

    It is local, without a proof, takes 1 ms, and has its target outside.
    """
    return {
        **{"question": question, "scenario": question, "solver": solver, "stratum": ""},
        **{"repeat": 0, "formulation": "one NLP a word", "engine": solver, "guess": "bearing"},
        **{"branch": "best", "profile": "default", "answerable": True, "presolved": False},
        **{"proves": None, "knows": "", "label": "", "via_x": None, "guesses": "one"},
        **{"target_x": 9.0, "closed": None},
        **{"floor_s": None, "subproblem_runs": None, "late": False, "elsewhere": False},
        "started": "2026-12-01T00:00:00Z",
        "presolve": "presolve=True" in solver,
        **{"verdict": "optimal", "right": True, "claim": "local", "lower_bound": float("nan")},
        **{"false_claim": False, "false_bound": False, "wrong_basin": False},
        **{"gap": 0.0, "miss": 0.0, "length": 4.0, "reference": 4.0, "reference_high": 4.0},
        **{"radius": 1.0, "region": "outside", "margin": 9.0, "wall_s": 1e-3, "tolerance": 1e-9},
    } | changes


def _settings(spec: str) -> dict[str, Any]:
    """A solver's settings; none of hostile names.

    Only a hostile row has such a name.
    """
    try:
        return settings(load(spec))
    except SolverError:
        return {}


def write_folder(
    folder: FilePath, name: str, rows: Iterable[dict[str, Any]], **manifest: Any
) -> FilePath:
    """Write a results folder with one part.

    Its section is that of the packaged experiment of its name.
    """
    rows = list(rows)
    named = read(name).experiment.section if name in packaged() else None
    named = "benchmark" if name == "benchmark" else named
    section = manifest.pop("section", named)
    experiment = {"name": name, "title": f"About {name}", "question": "?", "text": "a = 1"}
    (folder / "parts").mkdir(parents=True)
    pq.write_table(pa.Table.from_pylist(rows, schema=SCHEMA), folder / "parts" / "1.parquet")
    text = {
        "schema": VERSION,
        "experiment": experiment | {"section": section},
        "command": f"dubins-study run {name}",
        "versions": {"numpy": "2.3"},
        "machine": {"system": "Linux"},
        "solvers": {
            row["solver"]: {"settings": _settings(row["solver"]), "code_digest": row["code_digest"]}
            for row in rows
        },
        "gap_tolerance": 1e-4,
        "cells": len(rows),
        "git": {"commit": "abc"},
        "created": "2026-01-01T00:00:00Z",
        "finished": "2026-01-01T00:01:00Z",
    }
    (folder / "manifest.json").write_text(json.dumps(text | manifest), encoding="utf-8")
    return folder


_CELL = {
    **dict.fromkeys(("profile", "solver", "experiment", "scenario_id", "code_digest"), "a"),
    **{"branch": "best", "initial_guess": "cold", "label": ""},
    **{"x": 0.0, "y": 0.0, "heading": 0.0, "target_x": 4.0, "target_y": 1.0},
    **{"radius": 1.0, "speed": 1.0},
}


def attempts_of(
    place: FilePath, rows: pd.DataFrame, parts: Sequence[int] | None = None
) -> pd.DataFrame:
    """Write rows to folders and read them as attempts.

    Each experiment has a folder, and each row is a cell of its own. What is missing of a row is
    filled in; the index numbers the rows, and so their repeats. `parts` are the numbers of the
    parts that the rows go to; one part if None.
    """
    whole = rows.drop(columns=["repeat", "answerable"], errors="ignore").reset_index(drop=True)
    whole = whole.assign(**{name: v for name, v in _CELL.items() if name not in whole})
    whole = whole.astype(object).where(whole.notna(), None).assign(repeat=rows.index)
    part_numbers = 0 if parts is None else parts
    number = pd.Series(part_numbers, index=whole.index)
    folders = []
    for name, experiment_rows in whole.groupby("experiment", sort=False):
        records = experiment_rows.drop(columns="experiment").to_dict("records")
        folder = write_folder(place / str(name), str(name), records)
        (folder / "parts" / "1.parquet").unlink()
        for part, group in experiment_rows.groupby(number):
            table = pa.Table.from_pylist(group.to_dict("records"), schema=SCHEMA)
            pq.write_table(table, folder / "parts" / f"{part}.parquet")
        folders.append(folder)
    return load_folders(folders).attempts
