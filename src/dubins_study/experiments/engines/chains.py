"""Chains of cells under way: the next cell, the path that it starts from, and what is left."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import groupby
from typing import NamedTuple

from dubins_study.experiments.plan.cells import Cell, Chain, given_guess
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Key


class ChainState(NamedTuple):
    """The place of a chain's next cell, and the last path that arrived before it."""

    chain: Chain
    place: int
    path: Path | None

    @property
    def cell(self) -> Cell:
        return self.chain[self.place]

    def initial_guess(self) -> Path | None:
        return self.path if self.cell.initial_guess == "warm" else given_guess(self.cell)

    def after(self, path: Path | None) -> ChainState | None:
        """The state once the cell is attempted, if another one follows.

        Args:
            path: the cell's, if it arrived; after a failure the last path before serves on.
        """
        if self.place + 1 == len(self.chain):
            return None
        return ChainState(self.chain, self.place + 1, path or self.path)


def remaining_chains(
    chains: Iterable[Chain], before: Mapping[Key, Path], done: Mapping[Key, Path | None]
) -> tuple[list[Chain], dict[Key, Path]]:
    """What is left of chains, in pieces where cells between are done.

    Args:
        chains: single cells and sweeps.
        before: the path before the first cell of a chain, where there is one.
        done: the cells that are done, by their keys, with their paths if they arrived.

    Returns:
        The pieces, and the path before the first cell of each, by that cell's key. After a
        failure the last path that arrived serves on, as in a run that is not interrupted.
    """
    left: list[Chain] = []
    paths: dict[Key, Path] = {}
    for chain in chains:
        path = before.get(chain[0].key)
        for is_done, cells in groupby(chain, lambda cell: cell.key in done):
            piece = tuple(cells)
            if is_done:
                path = next(filter(None, (done[cell.key] for cell in reversed(piece))), path)
                continue
            left.append(piece)
            if path is not None:
                paths[piece[0].key] = path
    return left, paths
