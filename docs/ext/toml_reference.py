"""The keys of an experiment's TOML file.

Tables and a JSON schema come from the models that check the file.

Called as a program, it prints the schema for `experiment.schema.json` in the package.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from markdown_text import code, prose, table

from dubins_study.experiments.definition.experiment import Experiment

# Keys of pydantic's schema -> those of JSON schema. A value may be read by a function first, whose
# bounds pydantic leaves with names of its own.
_STANDARD = {
    **{"ge": "minimum", "gt": "exclusiveMinimum", "le": "maximum", "lt": "exclusiveMaximum"},
    "oneOf": "anyOf",
}


def json_schema() -> dict[str, Any]:
    """The schema (draft 2020-12) of an experiment's file.

    What a schema cannot say, such as the ways to write a target, is checked by the models alone.
    """
    schema: dict[str, Any] = _standard(Experiment.model_json_schema())
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **schema,
        "title": "An experiment of dubins-study",
    }


def _standard(schema: Any) -> Any:
    """The schema with standard names of its keys.

    They are renamed in all its parts.
    """
    if isinstance(schema, list):
        return [_standard(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    return {_STANDARD.get(key, key): _standard(part) for key, part in schema.items()}


def schema_text() -> str:
    """The schema as the text of its file."""
    return json.dumps(json_schema(), indent=1, ensure_ascii=False) + "\n"


def toml_table(model: str) -> str:
    """Every key of one table of the file.

    A row has type, default and meaning.
    """
    whole = json_schema()
    schema = whole if model == "Experiment" else whole["$defs"][model]
    needed = schema.get("required", [])
    rows = [
        (
            code(key),
            _kind(one),
            "needed" if key in needed else _default(one.get("default")),
            prose(one["description"]),
        )
        for key, one in schema["properties"].items()
    ]
    return table(("key", "value", "default", "meaning"), rows)


def _default(value: Any) -> str:
    if value is None or value == "":
        return "–"
    if isinstance(value, list):
        return code(str(value).replace("'", '"'))
    if isinstance(value, bool):
        return code(str(value).lower())
    return code(value)


def _kind(schema: dict[str, Any]) -> str:
    """The values of a key, in few words."""
    if "anyOf" in schema:
        kinds = [_kind(one) for one in schema["anyOf"] if one.get("type") != "null"]
        if "table `Spaced`" in kinds:
            return "[axis](#axes)"
        return "number or angle" if kinds == ["number", "text"] else " or ".join(kinds)
    if "$ref" in schema:
        return f"table `{schema['$ref'].rpartition('/')[2]}`"
    if "enum" in schema:
        return " or ".join(f'`"{value}"`' for value in schema["enum"])
    kind = schema["type"]
    if kind == "array" and "prefixItems" in schema:
        return "[" + ", ".join(_kind(one) for one in schema["prefixItems"]) + "]"
    if kind == "array":
        return f"list of {_kind(schema['items'])}"
    names = {
        "integer": "whole number",
        "string": "text",
        "boolean": "true or false",
        "object": "table",
    }
    return names.get(kind, kind) + _bounds(schema)


def _bounds(schema: dict[str, Any]) -> str:
    limits = {"minimum": "from", "exclusiveMinimum": "above", "maximum": "to"}
    texts = [f"{word} {_plain(schema[key])}" for key, word in limits.items() if key in schema]
    return f" {' '.join(texts)}" if texts else ""


def _plain(value: float) -> str:
    """A number without an exponent.

    Its digits are in groups of three.
    """
    return f"{value:,.12g}".replace(",", " ")


SOURCES: dict[str, Callable[..., str]] = {"toml": toml_table}

if __name__ == "__main__":
    print(schema_text(), end="")
