"""What the Parquet metadata of a streamed part say about its rows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, NamedTuple

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

if TYPE_CHECKING:
    import pyarrow as pa

# how the names of streamed parts begin
STREAM = "stream-"
# the largest count: beyond it a float is no longer exact
MAX_COUNT = 10**15
Count = Annotated[int, Field(ge=0, le=MAX_COUNT)]


class Kind(NamedTuple):
    """The rows of one outcome and verdict: how many, and the seconds that they took together."""

    outcome: str
    verdict: str
    rows: Count
    wall_s: FiniteFloat


class Chunk(BaseModel):
    """One chunk of a stream: a window of a block of scenarios, answered by one solver.

    Args:
        stream: identifies the block, the solver and the code that made the rows.
        question: identifies the block and the solver, whatever the code.
        solver, code_digest: of all rows.
        first, count: which rows of the stream the part holds.
        kinds: how many rows there are of each outcome and verdict.
    """

    model_config = ConfigDict(frozen=True, strict=True)

    stream: str
    question: str
    solver: str
    code_digest: str
    first: Count
    count: Count
    kinds: tuple[Kind, ...]

    @property
    def window(self) -> tuple[int, int]:
        """The first row of the stream that the part holds, and how many it holds."""
        return self.first, self.count

    @property
    def part_name(self) -> str:
        """The stem of the part's file name; names sort as the rows do."""
        return f"{STREAM}{self.stream}-{self.first:011d}-{self.count:06d}"


def row_kinds(rows: pa.Table) -> tuple[Kind, ...]:
    """Count rows by outcome and verdict (columns `outcome`, `verdict`, `wall_s`)."""
    grouped = rows.group_by(["outcome", "verdict"]).aggregate(
        [([], "count_all"), ("wall_s", "sum")]
    )
    return tuple(
        Kind(row["outcome"], row["verdict"], row["count_all"], row["wall_s_sum"] or 0.0)
        for row in grouped.to_pylist()
    )
