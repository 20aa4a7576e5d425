"""The manifest: what a results folder says of itself, checked when it is read."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Collection, Mapping
from pathlib import Path as FilePath
from typing import Any

from dubins_study.experiments.store.disk import StoreError, put, reason, refuse_link
from dubins_study.study.rows.schema import VERSION

MANIFEST = "manifest.json"
_MOST = 10**15  # of whatever is counted; what is larger is no float, or not exactly
# levels; what writes a manifest goes down level by level
_DEEPEST = 50
# two numbers on lines of their own; no text holds a line break that is not escaped
_PAIR = re.compile(r"\[\n\s+([^\s\"\[\],]+),\n\s+([^\s\"\[\],]+)\n\s+\]")


def read_manifest(folder: FilePath) -> dict[str, Any]:
    """The manifest of a results folder.

    Raises:
        StoreError: if there is none, or it is of another schema.
    """
    file = folder / MANIFEST
    refuse_link(file)
    if file.exists() and not file.is_file():  # a pipe would be waited for
        raise StoreError(f"{file} cannot be read: it is no file")
    try:
        manifest = json.loads(
            file.read_text(encoding="utf-8"), parse_constant=_number, parse_float=_number
        )
    except FileNotFoundError:
        raise StoreError(f"{folder} is no results folder: it has no {MANIFEST}") from None
    except OSError as error:
        raise StoreError(f"{file} cannot be read: {reason(error)}") from None
    except (ValueError, RecursionError) as error:
        raise StoreError(f"{file} cannot be read: not JSON: {error}") from None
    _check(file, manifest)
    if _deeper(manifest, _DEEPEST):
        raise StoreError(f"{file} is nested more than {_DEEPEST} levels deep; expected a manifest")
    return dict(manifest)


def _deeper(value: Any, levels: int) -> bool:
    """Whether a value of JSON has more levels."""
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return levels < 0 or any(_deeper(item, levels - 1) for item in inner)


def _number(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text:.20} is no finite number")
    return value


def _check(file: FilePath, manifest: Any) -> None:
    """Refuse what a run, a status or a merge would stumble over."""
    if not isinstance(manifest, dict):
        raise StoreError(f"{file} holds {manifest!r:.60}; expected a JSON object")
    schema = manifest.get("schema")
    if schema != VERSION or isinstance(schema, bool):
        raise StoreError(
            f"{file} has schema {schema!r:.60}; expected {VERSION}: run it again, into a new "
            "folder or with --restart"
        )
    experiment = manifest.get("experiment")
    if not (isinstance(experiment, dict) and {"name", "text"} <= experiment.keys()):
        raise StoreError(
            f"{file}: experiment is {experiment!r:.60}; expected an object with name and text"
        )
    for key, (fits, expected) in _EXPECTED.items():
        if not fits(manifest.get(key)):
            raise StoreError(f"{file}: {key} is {manifest.get(key)!r:.60}; expected {expected}")
    for spec, known in manifest.get("solvers", {}).items():
        if not (isinstance(known, dict) and isinstance(known.get("code_digest"), str)):
            raise StoreError(
                f"{file}: solvers.{spec:.60} is {known!r:.60}; expected an object with a code"
            )
        if not is_count(known.get("cells", 0)):
            raise StoreError(
                f"{file}: solvers.{spec:.60}.cells is {known['cells']!r:.60}; expected a whole "
                "number of at least 0"
            )


def is_count(value: object) -> bool:
    """Whether a value is a whole number of at least 0 that can be reckoned with."""
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= _MOST


def _is_time(value: object) -> bool:
    return isinstance(value, str | None)


def _is_runs(value: object) -> bool:
    listed = isinstance(value, list) and all(isinstance(run, dict) for run in value)
    return value is None or listed


def _is_object(value: object) -> bool:
    return isinstance(value, dict | None)


_EXPECTED = {
    "cells": (is_count, "a whole number of at least 0"),
    "solvers": (_is_object, "an object"),
    "created": (_is_time, "a time or null"),
    "finished": (_is_time, "a time or null"),
    "runs": (_is_runs, "a list of objects"),
}


def write_manifest(folder: FilePath, manifest: Mapping[str, Any]) -> None:
    """Replace the manifest in one step.

    Raises:
        StoreError: if the folder cannot be written.
    """
    text = json.dumps(manifest, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    content = _PAIR.sub(r"[\1, \2]", text).encode("utf-8", "replace")
    try:
        put(folder / MANIFEST, lambda file: _write(file, content))
    except OSError as error:
        raise StoreError(f"cannot write {folder / MANIFEST}: {reason(error)}") from None


def _write(file: FilePath, content: bytes) -> None:
    file.write_bytes(content)


def check_same(folder: FilePath, old: Mapping[str, Any], new: Mapping[str, Any]) -> None:
    """Refuse a folder that is of another experiment.

    Raises:
        StoreError: if name or text differ.
    """
    for key, what in (("name", "experiment"), ("text", "text of experiment")):
        if new[key] != old.get(key):
            raise StoreError(
                f"{folder} holds results of another {what} ({old.get(key)!r:.60}), not of "
                f"{new['name']!r:.60} as it is now; choose another --out, or --restart to throw them "
                "away"
            )


def taken_up(manifest: Mapping[str, Any], earlier: Mapping[str, Any] | None) -> dict[str, Any]:
    """The manifest of a run that goes on with a folder: its origin stays, its solvers add up."""
    if earlier is None:
        return {"runs": [], **manifest}
    # rows name their own versions
    kept = {key: earlier.get(key) for key in ("created", "finished")}
    solvers = {**(earlier.get("solvers") or {}), **manifest["solvers"]}
    return {**manifest, **kept, "solvers": solvers, "runs": list(earlier.get("runs") or ())}


def count_cells(
    manifest: dict[str, Any], asked: Collection[str], cells: Mapping[tuple[str, str], int]
) -> bool:
    """Note how many cells the folder is asked for, solver by solver, none of earlier code.

    Args:
        manifest: changed in place.
        asked: the specs that this run asks; of others what an earlier run asked stays.
        cells: how many this run asks for or the folder holds, by spec and code.

    Returns:
        Whether the folder will be finished when this run is.
    """
    completes = True
    for spec, known in manifest["solvers"].items():
        held = cells.get((spec, known["code_digest"]), 0)
        known["cells"] = held if spec in asked else max(held, known.get("cells", 0))
        completes = completes and known["cells"] <= held
    manifest["cells"] = sum(known["cells"] for known in manifest["solvers"].values())
    return completes
