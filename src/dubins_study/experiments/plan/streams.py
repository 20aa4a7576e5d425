"""Streams: large blocks of scenarios, which the closed form solves chunk by chunk as frames.

A streamed scenario has no cell, and the memory that a stream needs does not depend on its number of
rows.
"""

from __future__ import annotations

import hashlib
import itertools
import json
from collections.abc import Iterator
from typing import Any, NamedTuple

from dubins_study.experiments.definition.experiment import Experiment
from dubins_study.experiments.definition.scenario_block import Block
from dubins_study.experiments.plan.block_plan import BlockPlan, block_plans
from dubins_study.experiments.plan.duplicates import refuse_duplicates
from dubins_study.experiments.plan.scenario_columns import Window, block_size, tiled

CHUNK_ROWS = 2**17  # of each chunk but a stream's last: solved and certified in half a second


class Stream(NamedTuple):
    """All scenarios of a block as cold questions to the closed form, for one branch and repeat.

    Args:
        number: the number of the block in the experiment.
        block: the scenarios.
        solver, profile, branch, repeat, code_digest: the values of the rows' key columns.
    """

    number: int
    block: Block
    solver: str
    profile: str
    branch: str
    repeat: int
    code_digest: str

    @property
    def block_key(self) -> str:
        """The key of the block in the experiment's file, for messages."""
        return f"scenarios.{self.number}"

    @property
    def rows(self) -> int:
        """How many rows the stream has."""
        return block_size(self.block)

    @property
    def key_columns(self) -> dict[str, Any]:
        """The key columns that are the same in all rows: all but `scenario_id`."""
        return {
            "solver": self.solver,
            "profile": self.profile,
            "branch": self.branch,
            "initial_guess": "cold",
            "repeat": self.repeat,
            "code_digest": self.code_digest,
        }

    def chunks(self) -> Iterator[Window]:
        """The windows of all chunks, ascending."""
        return tiled(self.rows, CHUNK_ROWS)

    @property
    def id(self) -> str:
        """A hash of everything that the chunks and their rows depend on: 12 hexadecimal digits."""
        # Only the scenarios count: neither the block's other solvers nor its place in the file.
        block = self.block.model_dump(mode="json", exclude={"solvers", "branches", "guess_lengths"})
        text = json.dumps([CHUNK_ROWS, block, *self[2:]], sort_keys=True)
        return hashlib.sha256(text.encode("utf-8", "replace")).hexdigest()[:12]

    @property
    def question(self) -> str:
        """The id without the code digest: equal for two versions of the solver."""
        return self._replace(code_digest="").id


def streams(experiment: Experiment) -> list[Stream]:
    """The streams of an experiment, without duplicates.

    Raises:
        ExperimentError: if a block holds an invalid scenario, or a scenario twice (both are
            searched for in up to `duplicates.MOST_SEARCHED_ROWS` rows).
        SolverError: if a solver's spec is not valid.
    """
    if "cold" not in experiment.initial_guesses:
        return []
    plans = block_plans(experiment)
    unique: dict[str, Stream] = {}
    for plan in plans:
        for solver, branch, repeat in itertools.product(
            plan.stream_solvers, plan.branches, range(plan.repeats)
        ):
            stream = Stream(
                plan.number,
                plan.block,
                solver.spec,
                experiment.profile,
                branch,
                repeat,
                solver.code_digest,
            )
            unique.setdefault(stream.id, stream)
    refuse_duplicates(experiment.blocks, _overlaps(plans, list(unique.values())))
    return list(unique.values())


def _overlaps(plans: list[BlockPlan], stream_list: list[Stream]) -> dict[int, set[int]]:
    """Streamed block -> the other blocks that ask the same solver for the same branch."""
    questions = [
        {
            (solver.spec, branch)
            for solver in (*plan.cell_solvers, *plan.stream_solvers)
            for branch in plan.branches
        }
        for plan in plans
    ]
    overlaps: dict[int, set[int]] = {}
    for stream in stream_list:
        question = (stream.solver, stream.branch)
        others = {i for i, all_asked in enumerate(questions) if question in all_asked}
        overlaps.setdefault(stream.number, set()).update(others - {stream.number})
    return overlaps
