"""Scenarios that a streamed block repeats: found before the run, since none looks at keys later."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from dubins_study.experiments.definition.experiment import Block, ExperimentError
from dubins_study.experiments.plan.block_columns import Columns, Window, size, tiled, windows
from dubins_study.experiments.plan.scenario_ids import marks
from dubins_study.study.scenario import NUMBERS

# blocks that have more rows than these together are not looked through before the run
MOST_LOOKED_THROUGH = 10**7
_ROWS = 2**17

# a block and its number in the experiment
Numbered = tuple[int, Block]
# a row: the number of its block, its place there, and its scenario's numbers
_Found = tuple[int, int, tuple[bytes, ...]]


def refuse_repeats(blocks: Sequence[Block], alike: Mapping[int, Iterable[int]]) -> None:
    """Refuse a streamed block that holds a scenario twice, or one that another block holds.

    Blocks whose labels differ share no scenario. Above `MOST_LOOKED_THROUGH` rows nothing is
    looked at: a scenario that cannot be is then found when the run comes to it, and one that is
    asked for twice has two rows.

    Args:
        blocks: of the experiment.
        alike: number of every streamed block -> the others that ask the same solver and branch.

    Raises:
        ExperimentError: naming both blocks and rows, or as `columns.windows`.
    """
    groups: dict[frozenset[int], set[int]] = defaultdict(set)
    for number, others in alike.items():
        label = blocks[number].label
        groups[frozenset({number, *(i for i in others if blocks[i].label == label)})].add(number)
    for group, streamed in groups.items():
        together = [(number, blocks[number]) for number in sorted(group)]
        if sum(size(block) for _, block in together) <= MOST_LOOKED_THROUGH:
            _look_through(together, streamed)


def _look_through(together: list[Numbered], streamed: set[int]) -> None:
    seen = [
        marks(columns)
        for number, block in together
        for columns in windows(block, f"scenarios.{number}", _windows(block))
    ]
    ordered = np.sort(np.concatenate(seen))
    twice = np.unique(ordered[1:][ordered[1:] == ordered[:-1]])
    if not twice.size:
        return
    first: dict[tuple[bytes, ...], tuple[int, int]] = {}
    for number, row, scenario in _rows_marked(together, twice):
        other = first.setdefault(scenario, (number, row))
        if other != (number, row) and streamed & {number, other[0]}:
            raise ExperimentError(
                f"scenarios.{number}, scenario {row}: the same as scenarios.{other[0]}, scenario "
                f"{other[1]}; expected every scenario once where a block of so many goes to the "
                "closed form: give one of two blocks a label of its own"
            )


def _windows(block: Block) -> Iterable[Window]:
    return tiled(size(block), _ROWS)


def _rows_marked(together: list[Numbered], wanted: np.ndarray) -> Iterable[_Found]:
    for number, block in together:
        each = _windows(block)
        made = windows(block, f"scenarios.{number}", _windows(block))
        for (start, _), columns in zip(each, made, strict=True):
            for i in np.flatnonzero(np.isin(marks(columns), wanted)):
                yield number, start + int(i), _bits(columns, int(i))


def _bits(columns: Columns, row: int) -> tuple[bytes, ...]:
    return tuple(columns[name][row].tobytes() for name in NUMBERS)
