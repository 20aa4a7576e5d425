"""The stages of a `rising` run, by size.

In each stage cells of one size are solved; a run that is not `rising` has one stage. The size of a
route is its number of legs. If a solver solves no question of one size, it is not asked about
larger ones of the same label. The rows of these have the outcome `not_asked`.
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

# outcomes that do not show whether a solver finds the shortest routes of a size
_UNTOLD = (Outcome.UNSUPPORTED, Outcome.UNAVAILABLE)


def stages(chains: list[Chain], rising: bool) -> list[list[Chain]]:
    """The chains of each stage, by rising size.

    Each inner list is one stage. Without `rising` all chains are in one stage. A warm sweep is in
    the stage of its first cell.
    """
    by_size: dict[int, list[Chain]] = {}
    for chain in chains:
        size = 0
        if rising:
            size = chain[0].scenario.legs
        by_size.setdefault(size, []).append(chain)
    return [by_size[size] for size in sorted(by_size)]


def not_asked(folder: FilePath, unit: WorkUnit) -> tuple[WorkUnit, list[Row]]:
    """Split a stage: cells to ask, and rows.

    Returns the unit with the chains that are asked, and a row for each cell that is not. A cell is
    not asked if its solver has solved no question of the next smaller size and the same label.
    """
    rows = read_rows(folder, [*COLUMNS, "verdict", "outcome"]).to_pylist()
    # (solver, label) -> size -> whether a question counts as solved
    solved: dict[tuple[str, str], dict[int, bool]] = {}
    for row in rows:
        sizes = solved.setdefault((row["solver"], row["label"]), {})
        legs = scenario_of(row).legs
        sizes[legs] = sizes.get(legs, False) or _counts_as_solved(row)
    chains = []
    skipped = []
    for chain in unit.chains:
        scenario = chain[0].scenario
        sizes = solved.get((chain[0].solver, scenario.label), {})
        smaller = [legs for legs in sizes if legs < scenario.legs]
        if not smaller or sizes[max(smaller)]:
            chains.append(chain)
            continue
        reply = no_answer(
            Outcome.NOT_ASKED, "not asked: it found the shortest route of none with fewer legs"
        )
        skipped += [row_of(cell, cell.question(), unit.settings, reply) for cell in chain]
    return unit._replace(chains=chains), skipped


def _counts_as_solved(row: Row) -> bool:
    """Whether a solver may be asked larger questions.

    It may if the row's path may be the shortest, or if the solver could not be asked.
    """
    may_be_shortest = row["verdict"] in (Verdict.OPTIMAL, Verdict.UNDECIDED)
    return may_be_shortest or row["outcome"] in _UNTOLD
