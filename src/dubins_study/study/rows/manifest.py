"""Manifest of a results folder.

It describes the folder, and is checked when it is read.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import Annotated, Any, NamedTuple, Self

import numpy as np
from pydantic import (
    AliasChoices,
    BaseModel,
    ConfigDict,
    Field,
    ValidationError,
)

from dubins_study.study.rows.parts import ResultsError, os_errors_as
from dubins_study.study.rows.schema import VERSION
from dubins_study.study.tolerances import Tolerances
from dubins_study.study.values import plain, printable_values

MANIFEST = "manifest.json"
# Beyond 10^15 a float is no longer exact.
Count = Annotated[int, Field(ge=0, le=10**15)]


class _Record(BaseModel):
    """A record of the manifest.

    Unknown keys are kept as they are, so that rewriting a manifest loses nothing.
    """

    model_config = ConfigDict(frozen=True, strict=True, extra="allow", allow_inf_nan=False)

    def with_changes(self, **changes: Any) -> Self:
        """Copy with some fields changed."""
        return self.model_copy(update=changes)


class Definition(_Record):
    """Experiment that a folder holds the rows of.

    `text` is its TOML file; `section` is the section of the report that is about it.
    """

    name: str
    text: str
    title: str = ""
    question: str = ""
    section: str | None = None


class SolverEntry(_Record):
    """A solver of the experiment.

    It has its settings, the digest of its code, the versions of its packages, and the number of its
    cells.
    """

    code_digest: str
    settings: dict[str, Any] = {}
    packages: dict[str, Any] = {}
    cells: Count = 0


class MatrixEntry(_Record):
    """A pair of a formulation and an engine.

    `spec` asks for the pair, or `reason` says why there is no spec. `kind` is the engine's: it
    heads a group of engines in tables.
    """

    formulation: str
    engine: str
    kind: str = ""
    spec: str | None = None
    reason: str | None = None


# A run whose speed varied by more is reported as noisy.
NOISY = 0.05
_MIN_PROBES = 5


class Probe(NamedTuple):
    """A small piece of work that a run timed.

    `when` is in seconds since the run began; `took` is the seconds that it took.
    """

    when: Annotated[float, Field(ge=0, le=1e15)]
    took: Annotated[float, Field(gt=0, le=1e15)]
    machine: int = 0  # which of several machines, from 1; 0 where there is only one


def spread(probes: Sequence[Probe]) -> float | None:
    """Variation of a machine's speed, as a share.

    It is the range of the probes' seconds from the 5th to the 95th percentile, over their median.
    None for fewer than 5 probes, which say nothing.
    """
    if len(probes) < _MIN_PROBES:
        return None
    low, middle, high = np.percentile([probe.took for probe in probes], [5, 50, 95])
    return float((high - low) / middle)


def varied(probes: Sequence[Probe]) -> float | None:
    """Spread of the machine that varied most.

    None if no machine has enough probes.
    """
    machines = {probe.machine for probe in probes}
    spreads = [spread([p for p in probes if p.machine == machine]) for machine in machines]
    return max((share for share in spreads if share is not None), default=None)


class RunEntry(_Record):
    """A run: its request, its machine and its course.

    Moments are UTC, ISO 8601. The loads are processes that wanted a core in the last 1, 5 and 15
    minutes. The state is `running`, `finished` or `interrupted`; a killed run stays `running`.
    """

    run_id: str = ""
    command: str = ""
    executor: str = Field(default="local", validation_alias=AliasChoices("executor", "engine"))
    jobs: Annotated[int, Field(ge=1, le=2**31)] = 1
    threads: int | None = None
    time_limit_s: float | None = None
    memory_limit_gib: float | None = None
    machine: dict[str, Any] = {}
    governor: str = "unknown"
    git: dict[str, Any] = {}
    load_start: list[float] | None = None
    load_end: list[float] | None = None
    started: str = ""
    ended: str | None = None
    seconds: Annotated[float, Field(ge=0, le=1e15)] | None = None
    state: str = "unknown"
    probes: list[Probe] = []

    @property
    def spread(self) -> float | None:
        """Variation of the machine's speed (`varied`)."""
        return varied(self.probes)


class Manifest(_Record):
    """Description of a results folder, stored in it.

    `schema_version` is the file's key `schema`, a name that pydantic uses itself. `solvers` are by
    spec: rows of another code than an entry's are stale. Gaps of two attempts that differ by more
    than `gap_tolerance` contradict each other. `finished` is None until every cell has its row.
    """

    schema_version: int = Field(default=VERSION, alias="schema", ge=VERSION, le=VERSION)
    experiment: Definition
    command: str = ""
    seed: int | None = None
    time_limit_s: float | None = None
    memory_limit_gib: float | None = None
    profile: str | None = None
    gap_tolerance: Annotated[float, Field(gt=0)] = Tolerances().gap
    cells: Count
    matrix: list[MatrixEntry] = []
    solvers: dict[str, SolverEntry] = {}
    versions: dict[str, Any] = {}
    machine: dict[str, Any] = {}
    git: dict[str, Any] = {}
    created: str | None = None
    finished: str | None = None
    runs: list[RunEntry] = []

    @property
    def code_digests(self) -> dict[str, str]:
        """Code digests by solver.

        Rows of another code than a solver's digest do not count.
        """
        return {spec: entry.code_digest for spec, entry in self.solvers.items()}


def read_manifest(folder: FilePath, *, printable: bool = False) -> Manifest:
    """Read the manifest of a results folder.

    With `printable`, characters of its texts that cannot be printed are written out.
    """
    file = folder / MANIFEST
    if not file.exists():
        why = "it is not a folder"
        if folder.is_dir():
            why = f"it has no {MANIFEST}"
        raise ResultsError(f"{folder} is no results folder: {why}")
    with os_errors_as(f"{file} cannot be read"):
        text = file.read_bytes()
    try:
        content = json.loads(text)  # accepts texts that are not Unicode, such as file names
        if printable:
            content = printable_values(content)
        return Manifest.model_validate(content)
    except (ValueError, RecursionError) as error:
        raise ResultsError(
            f"{file} cannot be read: {_what(error)}; bring back a whole copy, or run the "
            "experiment again, into a new folder or with --restart"
        ) from None


def _what(error: ValueError | RecursionError) -> str:
    """Problem of a manifest, for a message.

    If several fields are wrong, it is the first.
    """
    if not isinstance(error, ValidationError):
        return str(error)
    first = error.errors()[0]
    key = ".".join(plain(str(step)) for step in first["loc"])
    place = ""
    if key:
        place = f"{key} is {first['input']!r:.60}: "
    return f"{place}{first['msg']}"
