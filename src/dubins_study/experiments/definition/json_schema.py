"""The keys of an experiment's TOML file as a JSON schema, which editors complete and check by."""

from __future__ import annotations

import json
from typing import Any

from dubins_study.experiments.definition.experiment import Experiment

# Beside the packaged experiments; `tests/docs/test_reference.py` compares it with the models.
SCHEMA_FILE = "experiment.schema.json"

# pydantic's names of bounds, where a function reads the value first -> those of JSON schema
_BOUNDS = {"ge": "minimum", "gt": "exclusiveMinimum", "le": "maximum", "lt": "exclusiveMaximum"}


def json_schema() -> dict[str, Any]:
    """The schema (draft 2020-12) of an experiment's file.

    What a schema cannot say, such as the ways to write a target, is checked by the models alone.
    """
    schema: dict[str, Any] = _with_bounds(Experiment.model_json_schema())
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **schema,
        "title": "An experiment of dubins-study",
    }


def _with_bounds(schema: Any) -> Any:
    """The schema with bounds by their standard names, in all its parts."""
    if isinstance(schema, list):
        return [_with_bounds(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    return {_BOUNDS.get(key, key): _with_bounds(part) for key, part in schema.items()}


def schema_text() -> str:
    """The schema as the text of `SCHEMA_FILE`."""
    return json.dumps(json_schema(), indent=1, ensure_ascii=False) + "\n"
