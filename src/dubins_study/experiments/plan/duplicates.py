"""Scenarios that a streamed block holds twice, or shares with another block.

Before a streamed row is solved, nothing checks whether its key exists already, so a scenario that
is asked for twice would have two rows. Duplicates are therefore refused before the run.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from dubins_study.experiments.definition.experiment import ExperimentError
from dubins_study.experiments.definition.scenario_block import Block
from dubins_study.experiments.plan.scenario_columns import Columns, block_size, tiled, windows
from dubins_study.study.scenario import NUMBERS

# Blocks with more rows than this in total are not searched for duplicates.
MOST_SEARCHED_ROWS = 10**7
_WINDOW_ROWS = 2**17


def refuse_duplicates(blocks: Sequence[Block], overlaps: Mapping[int, Iterable[int]]) -> None:
    """Refuse a streamed block that holds a scenario twice, or one that another block holds.

    Blocks with different labels share no scenario. Blocks with more than `MOST_SEARCHED_ROWS` rows
    in total are not searched: an invalid scenario in them is refused when the run reaches it, and
    a scenario that is asked for twice has two rows.

    Args:
        blocks: all blocks of the experiment.
        overlaps: the number of each streamed block, and the numbers of the other blocks that ask
            the same solver for the same branch.

    Raises:
        ExperimentError: naming both blocks and rows; or an error of `scenario_columns.windows`.
    """
    streamed_by_group: dict[frozenset[int], set[int]] = defaultdict(set)
    for number, others in overlaps.items():
        label = blocks[number].label
        group = frozenset({number, *(i for i in others if blocks[i].label == label)})
        streamed_by_group[group].add(number)
    for group, streamed in streamed_by_group.items():
        numbered = {number: blocks[number] for number in sorted(group)}
        if sum(map(block_size, numbered.values())) <= MOST_SEARCHED_ROWS:
            _search(numbered, streamed)


def _search(numbered: Mapping[int, Block], streamed: set[int]) -> None:
    """Raise an error for the first duplicate that lies in at least one streamed block."""
    marks = np.sort(np.concatenate([marks_of(columns) for _, _, columns in _windows(numbered)]))
    repeated = np.unique(marks[1:][marks[1:] == marks[:-1]])
    if not repeated.size:
        return
    first_rows: dict[tuple[bytes, ...], tuple[int, int]] = {}  # by the bytes of a scenario
    for number, first, columns in _windows(numbered):
        for i in np.flatnonzero(np.isin(marks_of(columns), repeated)):
            row = first + int(i)
            scenario = tuple(columns[name][i].tobytes() for name in NUMBERS)
            other = first_rows.setdefault(scenario, (number, row))
            if other != (number, row) and streamed & {number, other[0]}:
                raise ExperimentError(
                    f"scenarios.{number}, scenario {row}: the same as scenarios.{other[0]}, "
                    f"scenario {other[1]}; expected every scenario once where a block of so many "
                    "goes to the closed form: give one of two blocks a label of its own"
                )


def _windows(numbered: Mapping[int, Block]) -> Iterator[tuple[int, int, Columns]]:
    """Block number, first row and columns of every window of the blocks."""
    for number, block in numbered.items():
        places = list(tiled(block_size(block), _WINDOW_ROWS))
        columns_of = windows(block, f"scenarios.{number}", places)
        for (first, _), columns in zip(places, columns_of, strict=True):
            yield number, first, columns


def marks_of(columns: Columns) -> NDArray[np.uint64]:
    """One 64-bit number for each scenario, much cheaper to compute than its id.

    Scenarios that are equal to the last bit have equal marks; different scenarios almost never do.
    """
    bits = {name: columns[name].view(np.uint64) for name in NUMBERS}  # -0.0 differs from 0.0
    return np.asarray(pd.util.hash_pandas_object(pd.DataFrame(bits, copy=False), index=False))
