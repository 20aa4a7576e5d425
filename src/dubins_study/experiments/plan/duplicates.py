"""Scenarios that a streamed block holds twice, or shares with another block.

A streamed row is not looked up by its key when it is solved, so that a scenario asked for twice
would have two rows. Duplicates are therefore refused before the run.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from dubins_study.experiments.definition.experiment import ExperimentError
from dubins_study.experiments.definition.scenario_block import Block
from dubins_study.experiments.plan.scenario_columns import (
    Columns,
    Window,
    block_size,
    tiled,
    windows,
)
from dubins_study.experiments.plan.scenario_ids import marks
from dubins_study.study.scenario import NUMBERS

# Blocks that have more rows than these together are not searched for duplicates.
MOST_SEARCHED_ROWS = 10**7
_WINDOW_ROWS = 2**17

# the number of a block in the experiment, and the block
_NumberedBlock = tuple[int, Block]
# the bytes of a scenario's numbers
_Bits = tuple[bytes, ...]


def refuse_duplicates(blocks: Sequence[Block], overlaps: Mapping[int, Iterable[int]]) -> None:
    """Refuse a streamed block that holds a scenario twice, or one that another block holds.

    Blocks with different labels share no scenario. Blocks of more than `MOST_SEARCHED_ROWS` rows
    together are not searched: an invalid scenario in them is refused when the run comes to it, and
    a scenario that is asked for twice has two rows.

    Args:
        blocks: all blocks of the experiment.
        overlaps: the number of each streamed block, and the numbers of the other blocks that ask
            the same solver for the same branch.

    Raises:
        ExperimentError: naming both blocks and rows, or as `scenario_columns.windows`.
    """
    streamed_by_group: dict[frozenset[int], set[int]] = defaultdict(set)
    for number, others in overlaps.items():
        label = blocks[number].label
        group = frozenset({number, *(i for i in others if blocks[i].label == label)})
        streamed_by_group[group].add(number)
    for group, streamed in streamed_by_group.items():
        numbered = [(number, blocks[number]) for number in sorted(group)]
        if sum(block_size(block) for _, block in numbered) <= MOST_SEARCHED_ROWS:
            _search(numbered, streamed)


def _search(numbered: list[_NumberedBlock], streamed: set[int]) -> None:
    """Refuse the first duplicate in which a streamed block takes part."""
    repeated = _repeated_marks(numbered)
    if not repeated.size:
        return
    first_rows: dict[_Bits, tuple[int, int]] = {}
    for number, row, scenario in _marked_rows(numbered, repeated):
        other = first_rows.setdefault(scenario, (number, row))
        if other != (number, row) and streamed & {number, other[0]}:
            raise ExperimentError(
                f"scenarios.{number}, scenario {row}: the same as scenarios.{other[0]}, scenario "
                f"{other[1]}; expected every scenario once where a block of so many goes to the "
                "closed form: give one of two blocks a label of its own"
            )


def _repeated_marks(numbered: list[_NumberedBlock]) -> NDArray[np.uint64]:
    """The marks that two scenarios or more have; nearly always these scenarios are equal."""
    all_marks = [
        marks(columns)
        for number, block in numbered
        for columns in windows(block, f"scenarios.{number}", _all_windows(block))
    ]
    ordered = np.sort(np.concatenate(all_marks))
    return np.unique(ordered[1:][ordered[1:] == ordered[:-1]])


def _all_windows(block: Block) -> Iterator[Window]:
    return tiled(block_size(block), _WINDOW_ROWS)


def _marked_rows(
    numbered: list[_NumberedBlock], wanted: NDArray[np.uint64]
) -> Iterator[tuple[int, int, _Bits]]:
    """The block's number, the row and the scenario's bytes of every row with one of the marks."""
    for number, block in numbered:
        columns_of = windows(block, f"scenarios.{number}", _all_windows(block))
        for (first, _), columns in zip(_all_windows(block), columns_of, strict=True):
            for i in np.flatnonzero(np.isin(marks(columns), wanted)):
                yield number, first + int(i), _bits(columns, int(i))


def _bits(columns: Columns, row: int) -> _Bits:
    return tuple(columns[name][row].tobytes() for name in NUMBERS)
