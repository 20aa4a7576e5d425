"""The text of a mission file, and its reading.

The reading and the values are shared by all formats.
"""

from __future__ import annotations

import codecs
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path as FilePath
from typing import Any, NamedTuple

from dubins_study.errors import DubinsStudyError
from dubins_study.missions.mission import MissionError, MissionPoint
from dubins_study.study.angle import parse_angle
from dubins_study.study.scenario import FREE
from dubins_study.study.values import number_of_text, plain, real_number, short

_UTF_16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
# what parsing raises, and reading content of another shape than expected; SyntaxError is XML's
_MALFORMED = (
    *(AttributeError, LookupError, TypeError, ValueError),
    *(ArithmeticError, SyntaxError, RecursionError),
)
Points = list[MissionPoint]


class Reading(NamedTuple):
    """The points of a file, before conversion to metres.

    In a file of degrees x is the longitude, y the latitude, and headings count from the true east.
    """

    source: str
    points: Points
    passed: str = ""  # what is passed over, and how it is understood
    degrees: bool = True
    home: MissionPoint | None = None
    speed: float | None = None  # m/s


@contextmanager
def at(where: str) -> Iterator[None]:
    """Name the place in a refusal from the block.

    The place is such as `feature 3`, or a file's name.
    """
    try:
        yield
    except DubinsStudyError as error:
        raise MissionError(plain(f"{where}: {error}")) from None
    except _MALFORMED as error:
        message = f"cut, or not as its format has it ({error!r:.100})"
        raise MissionError(plain(f"{where}: {message}")) from None


def text_of(file: str | FilePath) -> str:
    """The text of a file.

    The file is in UTF-8, or in UTF-16 with a byte order mark.
    """
    try:
        content = FilePath(file).read_bytes()
    except OSError as error:
        raise MissionError(f"cannot be read: {error.strerror}") from None
    encoding = "utf-8-sig"
    if content.startswith(_UTF_16):
        encoding = "utf-16"
    text = content.decode(encoding, errors="replace")
    if "\0" in text or "\N{REPLACEMENT CHARACTER}" in text:
        raise MissionError(
            "cannot be read: it is not UTF-8 text, nor marked UTF-16: "
            "save a table as UTF-8; unpack a KMZ archive"
        )
    return text


def reading_of(source: str, points: Points, passed: Mapping[str, int], **fields: Any) -> Reading:
    """A reading with a note of skipped items.

    `passed` counts the skipped items by name; `fields` are other fields of the reading. Without
    points, a MissionError is raised.
    """
    counts = ", ".join(f"{count} {name}" for name, count in passed.items() if count)
    if not points:
        raise MissionError(f"there are no points; it has {counts or 'nothing'}")
    return Reading(source, points, counts and f"passed over: {counts}", **fields)


def each(kind: str, items: Iterable[Any], read: Callable[[Any], Iterable[MissionPoint]]) -> Points:
    """Read the points of all items.

    `read` returns the points of one item. Each point is marked with its item, such as `feature 3`;
    a refusal names it too.
    """
    points = []
    for count, item in enumerate(items, 1):
        where = f"{kind} {count}"
        with at(where):
            points += [point._replace(where=where) for point in read(item)]
    return points


def point_of(fields: Mapping[str, Any], compass: bool = False) -> MissionPoint:
    """The point with the given fields.

    `x` and `y` must be there. Values may be numbers or their texts; an empty value counts as
    missing. With `compass`, the heading runs clockwise from north.
    """
    x = number_of(fields["x"])
    y = number_of(fields["y"])
    if math.isnan(x + y):
        text = f"{fields['x']},{fields['y']}"
        raise MissionError(f"x,y is {text!r:.60}; expected two numbers")
    present = {name: value for name, value in fields.items() if value not in (None, "")}
    values: dict[str, Any] = {"name": plain(str(present.get("name", "")).strip())}
    for name in ("altitude", "speed"):
        if name in present:
            values[name] = number_of(present[name])
            if math.isnan(values[name]):
                raise MissionError(f"{name} is {short(present[name])}; expected a number")
    if present.get("heading", FREE) != FREE:
        with at("heading"):
            values["heading"] = heading_of(str(present["heading"]), compass)
    return MissionPoint(x, y, **values)


def number_of(value: Any) -> float:
    """A value or a text as a number.

    NaN if it is no number, or not finite.
    """
    try:
        if isinstance(value, str):
            value = number_of_text(value)
        number = real_number(value)
    except (TypeError, ValueError, OverflowError):
        return math.nan
    if math.isfinite(number):
        return number
    return math.nan


def heading_of(text: str, compass: bool) -> float:
    """A heading (rad, counterclockwise from east).

    With `compass`, the text counts clockwise from north, in degrees if it has no unit. Otherwise it
    counts counterclockwise from east, in rad if it has no unit.
    """
    if not compass:
        return parse_angle(text)
    if not text.strip("+-.0123456789"):
        text += "deg"
    return math.pi / 2 - parse_angle(text)
