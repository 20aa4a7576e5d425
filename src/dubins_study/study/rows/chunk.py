"""What the Parquet metadata of a streamed part say about its rows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, NamedTuple

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

if TYPE_CHECKING:
    import pyarrow as pa

# how the names of streamed parts begin
STREAM = "stream-"
# Beyond 10^15 a float is no longer exact.
Count = Annotated[int, Field(ge=0, le=10**15)]


class Kind(NamedTuple):
    """The rows of one outcome and verdict: how many, and the seconds that they took together."""

    outcome: str
    verdict: str
    rows: Count
    wall_s: FiniteFloat


class Chunk(BaseModel):
    """What a streamed part says about its rows: a window of a stream, answered by one solver.

    Args:
        stream: identifies the block of scenarios, the solver and the code that made the rows.
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
    kinds = rows.group_by(["outcome", "verdict"]).aggregate([([], "count_all"), ("wall_s", "sum")])
    columns = ("outcome", "verdict", "count_all", "wall_s_sum")
    counts = zip(*(kinds[name].to_pylist() for name in columns), strict=True)
    return tuple(Kind(outcome, verdict, n, wall_s or 0.0) for outcome, verdict, n, wall_s in counts)
