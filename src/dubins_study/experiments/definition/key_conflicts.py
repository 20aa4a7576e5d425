"""Keys of a file that do not go together, read from the file's tables whether valid or not.

The models refuse them too, but only once every key of a table is valid by itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pydantic import TypeAdapter, ValidationError

from dubins_study.experiments.definition.axes import Range
from dubins_study.experiments.definition.messages import Problem
from dubins_study.experiments.definition.scenario_block import (
    FIELDS,
    TARGETS,
    Block,
    one_target,
    refused,
    values_of,
)

_RANGE: TypeAdapter[Range] = TypeAdapter(Range)
FIRST = "first: expected a block with a sample and without solvers of its own, and there is none"


def key_conflicts(fields: dict[str, Any]) -> list[Problem]:
    """Blocks without a target, ranges of values that cannot be, and a `first` about nothing."""
    problems = []
    for number, block in tables(fields):
        problems += _target_problems(number, block)
        problems += _range_problems(number, block)
    blocks = [block for _, block in tables(fields)]
    sampled = any("sample" in block and "solvers" not in block for block in blocks)
    if isinstance(fields.get("first"), dict) and blocks and not sampled:
        problems.append(Problem(("first",), FIRST))
    return problems


def tables(fields: dict[str, Any]) -> Iterator[tuple[int, dict[str, Any]]]:
    """The number and the keys of every block that is a table."""
    blocks = fields.get("scenarios")
    for number, block in enumerate(blocks if isinstance(blocks, list) else ()):
        if isinstance(block, dict):
            yield number, block


def _ranges(block: dict[str, Any]) -> dict[str, Any]:
    sample = block.get("sample")
    ranges = sample.get("ranges") if isinstance(sample, dict) else None
    return ranges if isinstance(ranges, dict) else {}


def _target_problems(number: int, block: dict[str, Any]) -> list[Problem]:
    """No target, or two; not of a block with an unknown key: that may be a part of the target."""
    sampled = set(_ranges(block))
    unknown = (block.keys() - Block.model_fields.keys()) | (sampled - set(FIELDS))
    if unknown or one_target(sampled | block.keys()):
        return []
    return [Problem(("scenarios", number), f"scenarios.{number}: {TARGETS}")]


def _range_problems(number: int, block: dict[str, Any]) -> list[Problem]:
    problems = []
    for name, over in _ranges(block).items():
        try:
            sentence = refused(name, values_of(_RANGE.validate_python(over)))
        except ValidationError:  # no range: the models tell it
            continue
        if sentence:
            path = ("scenarios", number, "sample", "ranges", name)
            problems.append(Problem(path, f"{'.'.join(map(str, path))}: {sentence}"))
    return problems
