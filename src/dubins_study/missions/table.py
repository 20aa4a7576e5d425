"""Points of a text with columns.

Columns have names in several dialects, and several signs separate cells.
"""

from __future__ import annotations

import logging
import math
import re
from collections.abc import Collection, Sequence
from io import StringIO
from itertools import takewhile, zip_longest
from pathlib import Path as FilePath

from dubins_study.missions.mission import MissionError
from dubins_study.missions.reading import Points, Reading, at, number_of, point_of, text_of
from dubins_study.study.delimited import Row, Rows, read_rows
from dubins_study.study.values import plain

_LOG = logging.getLogger(__name__)
# names of columns for each field of a point, letters only
_NAMES = {
    "x": "x xm east eastm easting eastingm rechtswert",
    "y": "y ym north northm northing northingm hochwert",
    "longitude": "lon long lng longitude londeg lngdeg longitudedeg länge",
    "latitude": "lat latitude latdeg latitudedeg breite",
    "heading": "heading",
    "name": "name",
    "altitude": "alt altitude ele elevation altm altitudem elem elevationm höhe",
    "speed": "speed speedms",
}
_FIELDS = {name: field for field, names in _NAMES.items() for name in names.split()}
_DEGREES = ("longitude", "latitude")
_OF_A_ROUTE = ("x", "y", "name", "heading")


def read_points(file: str | FilePath) -> Points:
    """Read the points of a route from a table.

    The file has columns x and y, maybe name and heading. All other columns are named in a logged
    warning.
    """
    with at(str(file)):
        reading = read_table(text_of(file), used=_OF_A_ROUTE)
        if reading.degrees:
            raise MissionError(
                f"its points are in degrees; give the file as the argument: solve {file}"
            )
    if reading.passed:
        _LOG.warning("dubins-study: %s", plain(f"{file}: {reading.passed}"))
    return reading.points


def read_table(
    text: str,
    columns: Sequence[str] | None = None,
    compass: bool = False,
    used: Collection[str] = tuple(_NAMES),
) -> Reading:
    """Read the points of a text with columns.

    `columns` are names that replace the header's. Columns of fields that are not `used` are passed
    over, and named in the reading.
    """
    (rows, problems), comment = _split(text)
    place, first = next(iter(rows), Row("line 1", []))
    # the names: of `columns`, else of the header, else of a comment above the numbers
    has_header = not any(map(_is_number, first))
    names: Sequence[str] = first
    if comment and not has_header:
        names = comment
    source = place
    if columns is not None:
        names = columns
        source = "--columns"
    fields = [_field(name, used) for name in names]
    in_degrees = "longitude" in fields or "latitude" in fields
    x, y = ("x", "y")
    if in_degrees:
        x, y = _DEGREES
    if fields.count(x) != 1 or fields.count(y) != 1:
        raise MissionError(
            f"{source} is {','.join(names)!r:.60}; "
            "expected the column names x and y, once each, or lon and lat; "
            "or name them by --columns, such as --columns lon,lat or --columns -,x,y"
        )
    _check_fields(fields)
    if len(names) != len(first):
        raise MissionError(f"{place} has {len(first)} cells; expected {len(names)}, as named")
    if problems:
        raise MissionError(problems[0])
    # a first row that holds the names is no point
    first_data_row = int(has_header or names is first)
    points = []
    for place, cells in rows[first_data_row:]:
        row = dict(zip_longest(fields, map(str.strip, cells), fillvalue=""))
        with at(place):
            point = point_of({**row, "x": row[x], "y": row[y]}, compass)
            points.append(point._replace(where=place))
    if not points:
        raise MissionError("no points; expected a line each")
    expected_fields = {x, y, "-", *used}
    pairs = zip(names, fields, strict=True)
    passed = [name.strip() for name, field in pairs if field not in expected_fields]
    passed_text = ", ".join(name or "one without a name" for name in passed)
    note = ""
    if passed_text:
        note = f"columns that are passed over: {passed_text}"
    return Reading("table", points, note, degrees=in_degrees)


def _split(text: str) -> tuple[Rows, list[str]]:
    """The rows, and the cells of the comment above.

    Decimal commas of the rows have become points. The comment is the last of the lines at the top
    that begin with `#`; without one, the list is empty.
    """
    lines = list(StringIO(text, newline=""))
    comments = list(takewhile(lambda line: line.startswith("#"), lines))
    lines[: len(comments)] = ["\n"] * len(comments)
    first_line = next(filter(str.strip, lines), "")
    delimiter = next((sign for sign in ";\t" if sign in first_line), ",")
    if delimiter != ",":  # a number may have a decimal comma
        number = re.compile(rf"((?:^|{delimiter})\s*[+-]?\d*),(?=\d)")
        lines = [number.sub(r"\1.", line) for line in lines]
    comment = []
    if comments:
        comment = comments[-1].strip("# \r\n").split(delimiter)
    return read_rows(lines, delimiter), comment


def _field(name: str, used: Collection[str]) -> str:
    """The field that a column's name means.

    `Lon (deg)` means `longitude`. A name of no field, or of one not `used`, is returned as it is,
    in lower case.
    """
    field = _FIELDS.get(re.sub(r"[\W_]", "", name.lower()), "")
    if field in used or field in _DEGREES:
        return field
    return name.lower()


def _check_fields(fields: Sequence[str]) -> None:
    """Refuse fields that are there twice.

    A column such as `heading_deg` is refused too: its angles are not to be read as radians.
    """
    for field in fields:
        twice = field in _NAMES and fields.count(field) > 1
        if twice or ("heading" in field and field != "heading"):
            raise MissionError(
                f"column {field!r:.60}: expected one column heading, of angles such as 90deg, "
                "or radians, and one of each other kind"
            )


def _is_number(text: str) -> bool:
    return not math.isnan(number_of(text))


def read_tsplib(text: str, compass: bool) -> Reading:
    """Read the nodes of a TSPLIB file.

    Reinelt 1991, ORSA Journal on Computing 3, 376-384.
    """
    head, _, tail = text.partition("NODE_COORD_SECTION")
    kind = re.search(r"EDGE_WEIGHT_TYPE\s*:\s*(EUC_2D|CEIL_2D|ATT)", head)
    if kind is None:
        raise MissionError("expected EDGE_WEIGHT_TYPE EUC_2D, CEIL_2D or ATT")
    # up to the next keyword; empty lines replace those of the head, so that refusals name the line
    nodes = "\n" * head.count("\n") + re.split(r"\n\s*[A-Z]", tail)[0]
    table = "\n".join(",".join(line.split()) for line in nodes.split("\n"))
    return read_table(table, ("name", "x", "y"))._replace(source="TSPLIB")
