"""The keys of an experiment's TOML file, from the models that check it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from markdown_text import code, prose, table

from dubins_study.experiments.definition.experiment import json_schema


def toml_table(model: str) -> str:
    """Every key of one table of the file: type, default, meaning."""
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
    return code(str(value).lower() if isinstance(value, bool) else value)


def _kind(schema: dict[str, Any]) -> str:
    """The values that a key takes, in a few words."""
    if "anyOf" in schema:
        kinds = [_kind(one) for one in schema["anyOf"] if one.get("type") != "null"]
        return "[axis](#axes)" if "Linear" in "".join(kinds) else " or ".join(kinds)
    if "$ref" in schema:
        return f"table `{schema['$ref'].rpartition('/')[2]}`"
    if "enum" in schema:
        return " or ".join(f'`"{value}"`' for value in schema["enum"])
    kind = schema["type"]
    if kind == "array" and "prefixItems" in schema:
        return "[" + ", ".join(_kind(one) for one in schema["prefixItems"]) + "]"
    if kind == "array":
        return f"list of {_kind(schema['items'])}"
    if kind == ["number", "string"]:
        return "number or angle"
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
    """A number without an exponent, its digits in groups of three."""
    return f"{value:,.12g}".replace(",", " ")


SOURCES: dict[str, Callable[..., str]] = {"toml": toml_table}
