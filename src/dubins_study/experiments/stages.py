"""The stages of a run: if the experiment is `rising`, the cells of one size.

The size of a route is its number of legs. A solver that finds the shortest route of none with one
number of legs is not asked the longer ones of the same label; their rows say so.
"""

from __future__ import annotations

from pathlib import Path as FilePath

from dubins_study.asking.reply import no_answer
from dubins_study.experiments.executors.executor import WorkUnit
from dubins_study.experiments.executors.local import row_of
from dubins_study.experiments.plan.cells import Chain
from dubins_study.experiments.store.folder import read_rows
from dubins_study.study.rows.parts import Row
from dubins_study.study.scenario import COLUMNS
from dubins_study.study.scenario_frame import scenario_of
from dubins_study.study.words import Outcome, Verdict

# what does not tell whether a solver finds the shortest routes of a size
_UNTOLD = (Outcome.UNSUPPORTED, Outcome.UNAVAILABLE)


def stages(chains: list[Chain], rising: bool) -> list[list[Chain]]:
    """The chains of each stage; a warm sweep is where its first cell is."""
    by_size: dict[int, list[Chain]] = {}
    for chain in chains:
        size = chain[0].scenario.legs if rising else 0
        by_size.setdefault(size, []).append(chain)
    return [by_size[size] for size in sorted(by_size)]


def not_asked(folder: FilePath, unit: WorkUnit) -> tuple[WorkUnit, list[Row]]:
    """The cells of a stage that are worth asking after all earlier ones, and rows of the others."""
    rows = read_rows(folder, [*COLUMNS, "verdict", "outcome"]).to_pylist()
    solved: dict[tuple[str, str], dict[int, bool]] = {}  # by solver and label, then by size
    for row in rows:
        sizes = solved.setdefault((row["solver"], row["label"]), {})
        legs = scenario_of(row).legs
        sizes[legs] = sizes.get(legs, False) or (
            row["verdict"] in (Verdict.OPTIMAL, Verdict.UNDECIDED) or row["outcome"] in _UNTOLD
        )
    asked, skipped = [], []
    for chain in unit.chains:
        scenario = chain[0].scenario
        sizes = solved.get((chain[0].solver, scenario.label), {})
        smaller = [legs for legs in sizes if legs < scenario.legs]
        if not smaller or sizes[max(smaller)]:
            asked.append(chain)
            continue
        message = "not asked: it found the shortest route of none with fewer legs"
        reply = no_answer(Outcome.NOT_ASKED, message)
        skipped += [row_of(cell, cell.question(), unit.settings, reply) for cell in chain]
    return unit._replace(chains=asked), skipped
