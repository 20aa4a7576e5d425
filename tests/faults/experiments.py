"""Experiments that ask plug-ins, and their rows."""

from pathlib import Path

import pandas as pd

from dubins_study.experiments.store.folder import read_rows
from dubins_study.study.rows.schema import KEY, names

# what differs between two runs that find the same
MEASURED = ["build_s", "solve_s", "wall_s", "subproblem_s", "best_run_s"]
MEASURED += ["floor_s", "memory_mib"]
MEASURED += ["machine", "jobs", "limit_s", "executor", "run_id", "started"]


def experiment(folder: Path, *blocks: tuple[list[str], int], name: str = "faults") -> Path:
    """An experiment that asks solvers some questions.

    Each list of solvers has its own number of questions.
    """
    lines = [f'title = "{name}"', 'question = "is every row there?"', 'solvers = ["analytic"]']
    for number, (solvers, count) in enumerate(blocks):
        lines += [
            "[[scenarios]]",
            f'label = "block {number}"',
            f"target_x = {{ linear = [2.0, 9.0, {count}] }}",
            "target_y = 3.0",
            f"solvers = {solvers!r}",
        ]
    file = folder / f"{name}.toml"
    file.write_text("\n".join(lines) + "\n")
    return file


def rows(folder: Path) -> pd.DataFrame:
    """All rows of a folder with the plug-in's class."""
    table = read_rows(folder).to_pandas()
    table["plugin"] = table["solver"].str.extract(r":(\w+)", expand=False)
    return table


def lasting(table: pd.DataFrame) -> pd.DataFrame:
    """Columns in which two runs must agree.

    Rows are sorted by the key.
    """
    columns = table.drop(columns=MEASURED, errors="ignore")
    for column in ("curvatures", "lengths"):
        columns[column] = columns[column].map(lambda v: None if v is None else tuple(v))
    return columns.sort_values(names(KEY), ignore_index=True)
