"""A sample of attempts as JSON, small enough for the page once it is compressed."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from dubins_study.report.interactive.sample import FLAGS, MEASURED, SCENARIO, TEXTS
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import METHOD, names
from dubins_study.study.scenario import Pose

_DIGITS = 4  # that are kept of measured numbers; the page shows three
_OF_SCENARIO = ("scenario_id", "label", "region", "margin", *SCENARIO)
_MEASURED = [name for name in MEASURED if name not in ("evaluations", *_OF_SCENARIO)]
# what a solver is made of stands once in the header
_CODED = [name for name in TEXTS if name not in (*_OF_SCENARIO, *names(METHOD))]
MOST_ARCS = 3  # paths of more arcs are embedded as points on a grid
GRID = 4000  # steps along the larger side of their box; a drawing has some 1000 pixels
_FEWEST_POINTS, _MOST_POINTS = 40, 160
_ANGLE = 0.15  # rad between points of a path that only turns


def packed(rows: pd.DataFrame, more: Mapping[str, Any]) -> bytes:
    """The attempts of `sample.sample` as JSON.

    `count`; `texts` (column -> the texts that its numbers stand for, from 1; 0 is null); `columns`
    (column -> a number each row; `scenario` is a place in `scenarios`); `scenarios` (columns, with
    all digits); `paths` (`drawn`); and `more`.
    """
    texts: dict[str, list[str]] = {}
    columns: dict[str, list[Any]] = {}
    for name in _CODED:
        codes, values = pd.factorize(rows[name], sort=True)
        columns[name] = (codes + 1).tolist()
        texts[name] = [str(value) for value in values]
    for name in _MEASURED:
        columns[name] = [_rounded(value) for value in rows[name].astype("Float64")]
    columns["evaluations"] = [
        _rounded(value, 17) for value in rows["evaluations"].astype("Float64")
    ]
    columns |= {name: rows[name].eq(True).astype(int).tolist() for name in FLAGS}
    columns |= {name: rows[name].tolist() for name in ("repeat", "worst")}
    columns["scenario"], scenarios = _scenarios(rows)
    content: dict[str, Any] = {
        "count": len(rows),
        "texts": texts,
        "columns": columns,
        "scenarios": scenarios,
        "paths": [drawn(row) for row in rows.to_dict("records")],
        **more,
    }
    text = json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.encode()


def _rounded(value: Any, digits: int = _DIGITS) -> float | str | None:
    """A number in its first digits; JSON has no infinity, which JavaScript reads from a text."""
    if pd.isna(value):
        return None
    number = float(f"{value:.{digits}g}")
    return number if math.isfinite(number) else str(number).replace("inf", "Infinity")


def _scenarios(rows: pd.DataFrame) -> tuple[list[int], dict[str, list[Any]]]:
    """The place of each row's scenario in the table of scenarios, and that table by columns."""
    key = ["scenario_id", *SCENARIO]
    judged = rows.sort_values("region", kind="stable", na_position="last")
    table = judged.drop_duplicates(key).sort_index()
    numbered = table[key].assign(number=np.arange(len(table)))
    places = rows[key].merge(numbered, on=key, how="left")["number"]
    known = table[list(_OF_SCENARIO)].astype(object)
    columns = known.where(known.notna(), None)
    return places.tolist(), {name: columns[name].tolist() for name in _OF_SCENARIO}


def drawn(row: Mapping[Any, Any]) -> dict[str, Any] | None:
    """What is drawn of a row's path; None if there is none, or none that can be drawn.

    Of a few arcs the controls, in units of the turning radius: `arcs`, curvature and length of
    each. Of more arcs points: `box`, x and y of a grid's corner and its step (length unit), and
    `steps`, the differences of the points' columns and of their rows, the first ones from 0.
    """
    curvature, length = row["curvatures"], row["lengths"]
    if curvature is None or not len(curvature):
        return None
    if len(curvature) <= MOST_ARCS:
        radius = row["radius"]
        arcs = [[k * radius, s / radius] for k, s in zip(curvature, length, strict=True)]
        return {"arcs": [[_rounded(k, 7), _rounded(s, 7)] for k, s in arcs]}
    path = Path(Pose(row["x"], row["y"], row["heading"]), curvature, length)
    with np.errstate(all="ignore"):
        turned = float(np.abs(path.curvature * path.length).sum())
        if (path.length < 0).any() or not math.isfinite(turned + path.total_length):
            return None
        wanted = _FEWEST_POINTS + turned / _ANGLE
        points = path.sample(int(min(wanted, _MOST_POINTS)))[:, :2]
        low, size = points.min(axis=0), float(np.ptp(points, axis=0).max())
        if not math.isfinite(size + float(low.sum())):
            return None
    step = size / GRID or 1.0
    places = np.rint((points - low) / step).astype(int)
    steps = np.diff(places, axis=0, prepend=0)
    return {"box": [*low.tolist(), step], "steps": steps.T.tolist()}
