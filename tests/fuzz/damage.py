"""Results folders as strangers send them: every file of them changed in any way."""

from __future__ import annotations

import base64
import json
import os
import random
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from dubins_study.study.rows.schema import VERSION
from tests.fuzz.hostile import HOSTILE, deep

Dice = random.Random
_NUMBERS = (
    *(0, -1, 1, 2, 10**9, 2**63, 10**400, -(10**4000), True, None, 1e308, -1e308, 5e-324, 0.5),
    *(float("nan"), float("inf"), float("-inf")),
)


def odd(dice: Dice, depth: int = 3) -> Any:
    """Any value of JSON."""
    kind = dice.randrange(6 if depth else 3)
    if kind < 2:
        return dice.choice([*HOSTILE, "\ud800<b>", "x" * 10_000])
    if kind < 4:
        return dice.choice(_NUMBERS)
    size = dice.randrange(4)
    if kind == 4:
        return [odd(dice, depth - 1) for _ in range(size)]
    return {dice.choice(HOSTILE): odd(dice, depth - 1) for _ in range(size)}


def _own(file: Path) -> Path:
    """A file that earlier damage has not made a link to elsewhere, or a pipe, which is waited for.

    Raises:
        LookupError: if it has.
    """
    if file.is_symlink() or not file.is_file():
        raise LookupError(file)
    return file


def change_manifest(folder: Path, dice: Dice) -> None:
    """Other values, in any place of it."""
    file = _own(folder / "manifest.json")
    manifest = json.loads(file.read_text())
    for _ in range(dice.randint(1, 3)):
        place: Any = manifest
        key: Any = None
        while isinstance(place, dict | list) and len(place):
            key = dice.choice(list(place) if isinstance(place, dict) else range(len(place)))
            if not isinstance(place[key], dict | list) or dice.random() < 0.4:
                break
            place = place[key]
        how = dice.choice(["change", "change", "change", "drop", "add", "rename"])
        if key is None or (how == "add" and isinstance(place, dict)):
            if isinstance(place, dict):
                place[dice.choice(HOSTILE)] = odd(dice)
        elif how == "drop":
            del place[key]
        elif how == "rename" and isinstance(place, dict):
            place[dice.choice(HOSTILE)] = place.pop(key)
        else:
            place[key] = odd(dice)
    file.write_text(json.dumps(manifest))


def hostile_names(folder: Path, dice: Dice) -> None:
    """Every name and text of the manifest is hostile, and all of it is otherwise sound."""
    file = _own(folder / "manifest.json")
    manifest, text = json.loads(file.read_text()), dice.choice(HOSTILE)
    manifest |= {"command": text, "created": text, "machine": {text: text}, "git": {text: text}}
    manifest["experiment"] |= {"title": text, "question": text}
    manifest["versions"] = {text: text}
    manifest["solvers"][text] = {"settings": {text: text}, "code_digest": text, "cells": 1}
    names = ("run_id", "command", "engine", "state", "started", "governor")
    manifest["runs"][0] |= dict.fromkeys(names, text) | {"probes": [[i, 1 + i] for i in range(9)]}
    manifest["runs"][0]["machine"] = {"processor": text, "cores": text}
    if dice.random() < 0.5:
        manifest["experiment"]["name"] = text
    file.write_text(json.dumps(manifest))


def no_manifest(folder: Path, dice: Dice) -> None:
    """Something else in its place."""
    file = folder / "manifest.json"
    file.unlink()
    kind = dice.randrange(6)
    if kind == 0:
        file.mkdir()
    elif kind == 1:
        os.mkfifo(file)
    elif kind == 2:
        file.symlink_to("/etc/hostname")
    elif kind == 3:
        file.write_text(
            f'{{"schema": {VERSION}, "a": ' + deep(dice.choice([300, 10**5]), "dict") + "}"
        )
    elif kind == 4:
        file.write_bytes(dice.randbytes(60))
    else:
        file.write_text(json.dumps(odd(dice)))


def _a_part(folder: Path, dice: Dice) -> Path:
    parts = folder / "parts"
    if parts.is_symlink():
        raise LookupError(parts)
    return _own(dice.choice(sorted(parts.iterdir())))


def change_bytes(folder: Path, dice: Dice) -> None:
    """A part that is cut, longer, or flipped somewhere."""
    part = _a_part(folder, dice)
    content = bytearray(part.read_bytes())
    at = dice.choice([dice.randrange(len(content)), len(content) - 1 - dice.randrange(3000)])
    how = dice.randrange(4)
    if how == 0:
        del content[at:]
    elif how == 1:
        content[at:at] = dice.randbytes(dice.randint(1, 50))
    elif how == 2:
        for _ in range(dice.randint(1, 8)):
            content[dice.randrange(max(0, at), len(content))] ^= 1 << dice.randrange(8)
    else:
        content[at : at + 4] = b"\xff" * 4
    part.write_bytes(bytes(content))


def odd_files(folder: Path, dice: Dice) -> None:
    """Links, folders, pipes and other names where files of a folder should be."""
    part = _a_part(folder, dice)
    names = [
        "parts/\x1b[31mevil7.parquet",
        "parts/<b>.parquet",
        "parts/..parquet",
        "parts/.parquet",
    ]
    name = folder / dice.choice([*names, "damaged", ".lock", "parts/z.parquet", "report"])
    how = dice.randrange(7)
    if how == 0:
        _instead(name, lambda: part.rename(name))
    elif how == 1:
        _instead(name, lambda: shutil.copyfile(part, name))
    elif how == 2:
        _instead(name, lambda: name.symlink_to(dice.choice(["/etc/passwd", "..", "loop", "/"])))
    elif how == 3:
        _instead(name, name.mkdir)
    elif how == 4:
        _instead(name, lambda: os.mkfifo(name))
    elif how == 5:
        content = dice.choice([b"", b"PAR1", b"PAR1PAR1", b'{"pid": "\x1b[31m"}'])
        _instead(name, lambda: name.write_bytes(content))
    else:
        shutil.rmtree(folder / "parts")
        if dice.random() < 0.7:
            (folder / "parts").symlink_to(dice.choice(["/tmp", "nowhere", "parts"]))


def _instead(name: Path, make: Callable[[], Any]) -> None:
    if name.is_symlink() or name.is_file():
        name.unlink()
    if not name.exists():
        make()


def change_rows(folder: Path, dice: Dice) -> None:
    """A part that is sound Parquet, of rows that nobody could have written."""
    part = _a_part(folder, dice)
    table, said = pq.read_table(part), pq.read_metadata(part).metadata or {}
    for _ in range(dice.randint(1, 3)):
        at = dice.randrange(len(table.schema))
        table = _with_column(table, at, dice)
    if dice.random() < 0.3:
        said = dict(said)
        key = dice.choice([*said, b"ARROW:schema", b"pandas"])
        said[key] = dice.choice(
            [
                b"",
                b"\xff",
                base64.b64encode(b"x"),
                json.dumps(odd(dice)).encode(),
            ]
        )
    pq.write_table(table.replace_schema_metadata(said), part, store_schema=dice.random() < 0.5)


def _with_column(table: pa.Table, at: int, dice: Dice) -> pa.Table:
    field, rows = table.schema.field(at), len(table)
    values = table.column(at).to_pylist()
    some = [dice.random() < 0.5 for _ in range(rows)]

    def mixed(make: Callable[[], Any]) -> list[Any]:
        return [make() if other else kept for other, kept in zip(some, values, strict=True)]

    how = dice.randrange(10)
    if how == 0:
        column: Any = pa.nulls(rows, field.type)
    elif how == 1:
        column = pa.array(dice.choices(HOSTILE, k=rows))
    elif how == 2:
        column = pa.array(dice.choices(HOSTILE, k=rows)).dictionary_encode()
    elif how == 3:
        column = pa.array([{"a": odd_float(dice)}] * rows)
    elif how == 4:
        wrong = pa.py_buffer(b"\xff\xfe\xed\xa0\x80" * rows)
        offsets = pa.py_buffer(np.arange(0, 5 * rows + 1, 5, dtype=np.int32))
        column = pa.StringArray.from_buffers(rows, offsets, wrong)  # which is no UTF-8
    elif how == 5:
        return table.append_column(dice.choice(["x", field.name, "label\x1b[31m"]), pa.nulls(rows))
    elif how == 6:
        return table.remove_column(at)
    elif pa.types.is_list(field.type):
        column = pa.array(mixed(lambda: _controls(dice)), field.type)
    elif pa.types.is_floating(field.type):
        column = pa.array(mixed(lambda: odd_float(dice)), field.type)
    elif pa.types.is_integer(field.type):
        column = pa.array(mixed(lambda: dice.choice([0, -1, 2**63 - 1, -(2**63), None])))
    elif pa.types.is_string(field.type):
        column = pa.array(mixed(lambda: dice.choice(HOSTILE)))
    else:
        column = pa.array(mixed(lambda: dice.choice([None, True, False])))
    name, extra = field.name, {}
    if dice.random() < 0.1:
        name = dice.choice(["x", "label", "other"])
    if dice.random() < 0.1:
        kind = dice.choice(["pandas.period", "arrow.json", "arrow.py_extension_type", "arrow.uuid"])
        extra = {"ARROW:extension:name": kind, "ARROW:extension:metadata": dice.choice(["", "{}"])}
    return table.set_column(at, pa.field(name, column.type, metadata=extra), column)


def odd_float(dice: Dice) -> Any:
    numbers = (None, 0.0, -1.0, 1e308, -1e308, 5e-324, 1e16, float("nan"), float("inf"))
    return dice.choice(numbers)


def _controls(dice: Dice) -> Any:
    return dice.choice(
        [None, [], [None], [1.0], [1.0, None, 2.0], [1e308] * 3, [float("nan")], [0.0] * 5000]
    )


DAMAGES = (
    *(change_manifest, change_manifest, hostile_names, no_manifest, change_bytes, odd_files),
    *(change_rows, change_rows, change_rows),
)


def spoil(folder: Path, seed: int) -> None:
    """One to three damages, drawn from the seed."""
    dice = Dice(seed)
    for _ in range(dice.choice([1, 1, 1, 2, 3])):
        try:
            dice.choice(DAMAGES)(folder, dice)
        except (OSError, ValueError, TypeError, LookupError, RecursionError, pa.ArrowException):
            continue  # what an earlier damage took away
