"""A sample of attempts as bytes that a script of the page unpacks."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from dubins_study.report.interactive.polylines import polylines
from dubins_study.report.interactive.sample import (
    CURVATURES,
    FLAGS,
    LENGTHS,
    MEASURED,
    MOST_ARCS,
    SCENARIO,
    TEXTS,
)
from dubins_study.study.rows.schema import METHOD, names
from dubins_study.study.scenario import Pose

# Bits of a mantissa that are kept of measured numbers: four digits, of which the page shows three.
_BITS = 14
_OF_SCENARIO = ("scenario_id", "label", "region", "margin", *SCENARIO)
# each of them once, in the header
_OF_SOLVER = names(METHOD)
_MEASURED = [name for name in MEASURED if name not in ("evaluations", *_OF_SCENARIO)]
_CODED = [name for name in TEXTS if name not in (*_OF_SCENARIO, *_OF_SOLVER)]


class Packed(NamedTuple):
    """Attempts for the page.

    Args:
        arrays: the bytes of all arrays, one behind the other, each as planes: the first bytes of
            all its numbers, then their second bytes, ... (little-endian). Planes compress better.
        header: as JSON: `arrays` (name -> type, offset in bytes, count), `texts` (name -> the
            texts that a column's numbers stand for, from 1; 0 is null), and `scenarios` (columns).
    """

    arrays: bytes
    header: bytes


def pack(rows: pd.DataFrame, more: Mapping[str, Any]) -> Packed:
    """The attempts of `sample.sample` for the page.

    Numbers that the page compares or repeats exactly, those of scenarios, are of 64 bits; measured
    numbers are rounded to four digits. The controls of paths of a few arcs are of 32 bits, in units
    of the turning radius: they are only drawn, and the numbers of the check stand beside them. Of
    paths of many arcs there are points of a grid that no drawing resolves.

    Args:
        more: further values of the header.
    """
    arrays: dict[str, NDArray[Any]] = {}
    texts: dict[str, list[str]] = {}
    for name in _CODED:
        codes, values = pd.factorize(rows[name], sort=True)
        arrays[name] = (codes + 1).astype("<u2")
        texts[name] = [str(value) for value in values]
    for name in _MEASURED:
        arrays[name] = _rounded(rows[name])
    # numbers of 32 bits hold counts up to 16 777 216 exactly
    arrays["evaluations"] = rows["evaluations"].to_numpy("<f4", na_value=np.nan)
    flags = sum(rows[name].eq(True).to_numpy() << bit for bit, name in enumerate(FLAGS))
    arrays["flags"] = np.asarray(flags, dtype="u1")
    arrays["repeat"] = rows["repeat"].to_numpy(dtype="<u4")
    arrays["worst"] = rows["worst"].to_numpy(dtype="u1")
    place, scenarios = _scenarios(rows)
    arrays["scenario"] = place.astype("<u4")
    arrays |= _arcs(rows) | _lines(rows)
    directory, content = {}, []
    offset = 0
    for name, array in arrays.items():
        directory[name] = [array.dtype.str.lstrip("<|"), offset, array.size]
        content.append(_planes(array))
        offset += array.nbytes
    header = {"arrays": directory, "texts": texts, "scenarios": scenarios, "count": len(rows)}
    header |= more
    text = json.dumps(header, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return Packed(b"".join(content), text.encode())


def _rounded(values: pd.Series) -> NDArray[np.float32]:
    """Numbers of 32 bits with a mantissa of `_BITS`; null is not a number."""
    with np.errstate(over="ignore"):
        numbers = values.to_numpy(dtype=np.float64, na_value=np.nan).astype("<f4")
    bits = numbers.view("<u4")
    cut = 23 - _BITS
    rounded = ((bits + (1 << (cut - 1))) >> cut << cut).astype("<u4").view("<f4")
    return np.where(np.isfinite(numbers), rounded, numbers).astype("<f4")


def _planes(array: NDArray[Any]) -> bytes:
    plain = np.ascontiguousarray(array)
    return plain.view("u1").reshape(-1, array.itemsize).T.tobytes()


def _scenarios(rows: pd.DataFrame) -> tuple[NDArray[np.int64], dict[str, list[Any]]]:
    """The place of each row's scenario in the table of scenarios, and that table by columns."""
    key = ["scenario_id", *SCENARIO]
    judged = rows.sort_values("region", kind="stable", na_position="last")
    table = judged.drop_duplicates(key).sort_index()
    numbered = table[key].assign(number=np.arange(len(table)))
    places = rows[key].merge(numbered, on=key, how="left")["number"].to_numpy()
    columns = (
        table[list(_OF_SCENARIO)].astype(object).where(table[list(_OF_SCENARIO)].notna(), None)
    )
    return places, {name: columns[name].tolist() for name in _OF_SCENARIO}


def _arcs(rows: pd.DataFrame) -> dict[str, NDArray[Any]]:
    """The controls of paths of a few arcs: `arcs` a row, `turns` and `drives` one behind the other.

    `turns` are curvatures times the radius, `drives` are lengths in radii; of longer paths, and of
    those without a path, there are none.
    """
    few = rows["arcs"].le(MOST_ARCS)
    number = rows["arcs"].where(few, 0).to_numpy()
    driven = np.arange(MOST_ARCS) < number[:, None]
    radius = rows["radius"].to_numpy()[:, None]
    with np.errstate(over="ignore"):
        turns = (rows[list(CURVATURES)].to_numpy(float) * radius)[driven].astype("<f4")
        drives = (rows[list(LENGTHS)].to_numpy(float) / radius)[driven].astype("<f4")
    return {"arcs": number.astype("u1"), "turns": turns, "drives": drives}


def _lines(rows: pd.DataFrame) -> dict[str, NDArray[Any]]:
    """The polylines of longer paths: `points` a row, `boxes` (x, y, step) and `steps` of all.

    `steps` are differences of grid places: x of all points, then y; the first from 0.
    """
    counts = np.zeros(len(rows), dtype="<u2")
    drawn: dict[int, tuple[NDArray[np.float64], NDArray[np.int16]]] = {}
    long = rows[rows["arcs"] > MOST_ARCS]
    for _, group in long.groupby("arcs"):
        controls = (np.stack(group[name].tolist()) for name in ("curvatures", "lengths"))
        lines = polylines(group[list(Pose._fields)].to_numpy(float), *controls)
        counts[group.index] = lines.counts
        each = np.split(lines.places, np.cumsum(lines.counts)[:-1])
        drawn |= dict(zip(group.index, zip(lines.boxes, each, strict=True), strict=True))
    ordered = [drawn[row] for row in long.index if counts[row]]
    steps = [np.diff(places, axis=0, prepend=np.int16(0)) for _, places in ordered]
    return {
        "points": counts,
        "boxes": np.array([box for box, _ in ordered], dtype="<f8").ravel(),
        "steps": np.concatenate([*steps, np.zeros((0, 2), dtype="<i2")]).T.ravel(),
    }
