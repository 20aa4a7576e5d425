"""Paths given by their controls, integrated exactly.

A path is a start pose, then arcs of constant curvature.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby, pairwise
from operator import mul
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dubins_study.study.arrays import BoolArray, FloatArray, IntArray
from dubins_study.study.picture import svg
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.tangent_plane import plane_at
from dubins_study.study.values import doubles, real_array, real_number, short
from dubins_study.study.words import Claim, short_word

if TYPE_CHECKING:
    import pandas as pd

CLAIMS = tuple(Claim)
# An arc with less than this share of the path's largest curvature counts as straight.
RIPPLE = 1e-3
# Lengths; up to this many a loop adds faster than numpy, and in the same order.
_FEW = 7
_LOOPED = 24  # arcs up to which a loop is quicker than whole arrays
_MEETS = 1e-6  # radii and rad; largest gap between the end of a path and the start of the next
_MOST_POINTS = 10_000_000  # of a path that is sampled or exported
_MOST_PARTS = 100_000  # parts of all turns of a path that is drawn
# side (1 left, 0 straight, -1 right), size of the turn (rad), length (length unit)
Piece = tuple[int, float, float]


@dataclass(frozen=True, eq=False)
class Path:
    """A path given by its controls.

    Each control is held constant over its length (zero-order hold).

    Args:
        start: initial pose.
        curvatures: of the arcs, shape (n,), 1 / length unit, positive to the left.
        lengths: of the arcs, shape (n,), length unit.

    Any numbers are accepted, since a path may come from a solver that went wrong. Whether it can be
    driven (finite, no negative length) is for `study.check.verdict` to say.
    """

    start: Pose
    curvatures: FloatArray
    lengths: FloatArray

    def __init__(self, start: Pose, curvatures: ArrayLike, lengths: ArrayLike) -> None:
        k = doubles("curvatures", curvatures).copy()
        s = doubles("lengths", lengths).copy()
        if k.ndim != 1 or k.shape != s.shape:
            raise ValueError(
                f"curvatures has shape {k.shape} and lengths {s.shape}; expected one shape (n,)"
            )
        for array in (k, s):
            array.setflags(write=False)
        object.__setattr__(self, "start", Pose(*map(real_number, start)))
        object.__setattr__(self, "curvatures", k)
        object.__setattr__(self, "lengths", s)

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Path)
            and self.start == other.start
            and np.array_equal(self.curvatures, other.curvatures)
            and np.array_equal(self.lengths, other.lengths)
        )

    __hash__ = None  # type: ignore[assignment]  # arrays cannot be hashed, nor should a path be

    @classmethod
    def join(cls, paths: Iterable[Path]) -> Path:
        """Join paths that follow one another.

        Each path begins where the one before it ends.

        Raises:
            ValueError: if there are no paths, or if two of them do not meet. Two paths meet if the
                gap is at most 1e-6 of their smallest radius, or of the longer path if both are
                straight, and if their headings differ by at most 1e-6 rad, full turns left out.
        """
        parts = list(paths)
        if not parts:
            raise ValueError("there is no path to join; expected one or more")
        for place, (before, after) in enumerate(pairwise(parts), 1):
            away = math.dist(before.end[:2], after.start[:2])
            turned = abs(math.remainder(after.start.heading - before.end.heading, math.tau))
            bends = np.abs(np.concatenate((before.curvatures, after.curvatures)))
            size = max(before.length, after.length)
            if bends.any():
                size = 1 / float(bends.max())
            if not (away <= _MEETS * size and turned <= _MEETS):
                apart = f"{away:.3g} away, turned by {turned:.3g} rad"
                raise ValueError(f"path {place + 1} begins {apart}, from the end of path {place}")
        return cls(
            parts[0].start,
            np.concatenate([path.curvatures for path in parts]),
            np.concatenate([path.lengths for path in parts]),
        )

    def __add__(self, other: Path) -> Path:
        """Join this path and the next; see `join`."""
        return Path.join((self, other))

    @cached_property
    def length(self) -> float:
        """Sum of the arcs' lengths (length unit)."""
        if self.lengths.size <= _FEW:
            return sum(self.lengths.tolist(), 0.0)
        return float(self.lengths.sum())

    @property
    def turn(self) -> float:
        """Net heading change (rad), positive to the left.

        It is not wrapped.
        """
        return float((self.curvatures * self.lengths).sum())

    @property
    def poses(self) -> FloatArray:
        """Poses at the ends of the arcs.

        Shape (n + 1, 3): x, y (length unit), heading (rad, not wrapped). Row 0 is the start.
        """
        return corners(self.start, self.curvatures, self.lengths)

    @property
    def end(self) -> Pose:
        return end_of(self.start, self.curvatures, self.lengths)

    def at(self, distance: ArrayLike) -> FloatArray:
        """Poses at given distances along the path.

        Args:
            distance: shape (m,), or one number; length unit, clipped to [0, total length].

        Returns:
            An array of shape (m, 3) with x, y (length unit) and heading (rad, not wrapped).
        """
        d = np.clip(np.atleast_1d(np.asarray(distance, dtype=np.float64)), 0.0, self._ends[-1])
        if not self.lengths.size:
            return np.tile(np.array(self.start), (d.size, 1))
        arc = self._arc_at(d)
        return _advance(self.poses[arc], self.curvatures[arc], d - self._ends[arc])

    def at_time(self, time: ArrayLike, speed: float = 1.0) -> FloatArray:
        """Poses at given times from the start.

        Args:
            time: shape (m,), or one number; time unit, clipped to that of the whole path.
            speed: length units per time unit.

        Returns:
            An array of shape (m, 3) with x, y (length unit) and heading (rad, not wrapped).
        """
        return self.at(np.asarray(time, dtype=np.float64) * real_number(speed))

    def curvature_at(self, distance: ArrayLike) -> FloatArray:
        """Curvatures at given distances along the path.

        Shape (m,), 1 / length unit. Where two arcs meet, the curvature of the later one counts. A
        path without arcs has curvature 0.
        """
        d = np.atleast_1d(np.asarray(distance, dtype=np.float64))
        if not self.lengths.size:
            return np.zeros(d.size)
        return self.curvatures[self._arc_at(d)]

    @property
    def _ends(self) -> FloatArray:
        """Distances from the start to the arcs' ends.

        Shape (n + 1,); the first is 0.
        """
        return np.concatenate(([0.0], np.cumsum(self.lengths)))

    def _arc_at(self, distance: FloatArray) -> IntArray:
        """Index of the arc at each distance.

        Where two arcs meet, the later one counts.
        """
        arc = np.searchsorted(self._ends, distance, side="right") - 1
        return np.clip(arc, 0, self.lengths.size - 1)

    @overload
    def sample(self, n: int) -> FloatArray: ...
    @overload
    def sample(self, n: None = None, *, step: float) -> pd.DataFrame: ...
    def sample(self, n: int | None = None, *, step: float | None = None) -> FloatArray | Any:
        """Poses along the path, evenly spaced.

        Give either their number `n` or the distance `step` between them.

        Args:
            n: number of poses, at equal arc length from the start to the end.
            step: distance along the path from each pose to the next (length unit); the last step
                ends at the end of the path and may be shorter.

        Returns:
            With `n` an array of shape (n, 3): x, y (length unit), heading (rad, not wrapped).
            With `step` a frame with the columns `s` (distance along the path), `x`, `y`, `heading`
            and `curvature` (1 / length unit); where two arcs meet, the later one's curvature.

        Raises:
            ValueError: if the step is no positive number, or for more than ten million poses.
        """
        if (n is None) == (step is None):
            raise ValueError(f"n is {short(n)} and step is {short(step)}; expected one of them")
        if n is not None:
            if n > _MOST_POINTS:
                raise ValueError(f"n is {short(n)}; expected at most {_MOST_POINTS} poses")
            return self.at(np.linspace(0.0, self.length, n))
        import pandas as pd

        total = self.length
        try:
            size = real_number(step)
        except TypeError:
            size = math.nan
        if not 0 < size < math.inf or not total / size <= _MOST_POINTS:
            most = f"at most {_MOST_POINTS} poses of a finite path"
            raise ValueError(f"step is {short(step)}; expected a number above 0 and {most}")
        # a path without length has one pose only
        steps = 0
        if total > 0:
            # a remainder that is only rounding gets no step of its own
            steps = max(math.ceil(total / size * (1 - 1e-12)), 1)
        s = np.append(size * np.arange(steps), total)
        curvature = self.curvature_at(s)
        x, y, heading = self.at(s).T
        return pd.DataFrame({"s": s, "x": x, "y": y, "heading": heading, "curvature": curvature})

    def to_csv(self, file: Any = None, *, step: float) -> str | None:
        """Write `sample(step=step)` as CSV.

        The CSV is written to `file`, which is open or given by its path, and None is returned.
        Without a file, the text is returned.

        Raises:
            ValueError: if the step is no positive number, or for more than ten million poses.
            OSError: if the file cannot be written.
        """
        text: str | None = self.sample(step=step).to_csv(file, index=False)
        return text

    def to_geojson(
        self,
        chord_error: float = 1e-3,
        *,
        origin: tuple[float, float] | None = None,
        **properties: Any,
    ) -> dict[str, Any]:
        """Convert the path to a GeoJSON Feature for `json.dump`.

        The geometry is a LineString, or a Point if the path has no length.

        Without an origin the coordinates are the path's own x and y in its length unit. They are
        not longitude and latitude, which RFC 7946 assumes unless something else is agreed.

        Args:
            chord_error: largest distance between an arc and its chords, as a share of the smallest
                radius of the path's arcs.
            origin: latitude and longitude (degrees, WGS 84) of the point (0, 0), for a path in
                metres whose x points east and whose y points north. The plane is the ellipsoid's
                azimuthal equidistant one there; `Scenario.from_lonlat` with this origin undoes it.
            properties: further properties of the feature, each a value that JSON has.

        Returns:
            A Feature. Its properties are `length`, `word`, `radius` (the smallest of its arcs; null
            for a straight path), `start_heading_rad` and `end_heading_rad` (from -pi to pi),
            `chord_error` (length unit), and those given.

        Raises:
            ValueError: if the path cannot be driven, the chord error is not between 0 and 1, it
                needs more than ten million points, or the origin is no place on Earth.
        """
        share = real_number(chord_error)
        if not 0 < share <= 1:
            raise ValueError(f"chord_error is {short(chord_error)}; expected a share up to 1")
        if not drivable(self):
            raise ValueError("the path has a number that is not finite, or a negative length")
        points, radius = self._chords(share)
        if origin is not None:
            points = plane_at(origin).to_earth(points)
        line = points.tolist()
        geometry = {"type": "LineString", "coordinates": line}
        if len(line) == 1:
            geometry = {"type": "Point", "coordinates": line[0]}
        return {
            "type": "Feature",
            "geometry": geometry,
            "properties": {
                "length": self.length,
                "word": self.word(),
                "radius": radius,
                "start_heading_rad": math.remainder(self.start.heading, math.tau),
                "end_heading_rad": math.remainder(self.end.heading, math.tau),
                "chord_error": share * (radius or 0.0),
                **properties,
            },
        }

    def _chords(self, share: float) -> tuple[FloatArray, float | None]:
        """Ends of chords along the path, and a radius.

        The ends are x and y, shape (m, 2). The radius is the smallest of the arcs (length unit),
        None for a straight path. Each chord is within `share` times that radius from its arc.
        """
        driven = self.lengths > 0
        bend = np.abs(self.curvatures[driven])
        lengths = self.lengths[driven]
        sharpest = float(bend.max(initial=0.0))
        radius = None
        if sharpest >= np.finfo(np.float64).tiny:  # a smaller curvature has a radius that overflows
            radius = 1 / sharpest
        # a chord over the angle a of an arc of radius r is r (1 - cos(a / 2)) from the arc
        angle = 2 * np.arccos(np.maximum(1.0 - share * bend * (radius or 0.0), 0.0))
        parts = np.maximum(np.ceil(bend * lengths / np.where(angle > 0, angle, 1.0)), 1.0)
        if parts.sum() > _MOST_POINTS:
            most = f"at most {_MOST_POINTS} points"
            raise ValueError(f"the path has {parts.sum():.3g} points; expected {most}")
        return self.at(_cuts(lengths, parts.astype(int)))[:, :2], radius

    def _repr_svg_(self) -> str | None:
        """Draw the path for a notebook.

        A dot marks the start. None if the path cannot be driven or has no length.
        """
        return self._drawing(f"{short_word(self.word(), 24)}, length {self.length:.6g}")

    def _drawing(self, caption: str) -> str | None:
        """SVG of the path with a caption.

        None if the path cannot be driven or has no length.
        """
        if not drivable(self) or not self.length > 0:
            return None
        points, _ = outline(self)
        return svg(points[:, :2], caption)

    def word(self, tolerance: float = 1e-6) -> str:
        """Letters of the path: L, S or R.

        Each run of arcs of one kind has one letter. A run to one side that turns by no more than
        `tolerance` (rad) counts as straight. A straight that is no longer than `tolerance` times
        the path's length has no letter.
        """
        curvatures = self.curvatures.tolist()
        lengths = self.lengths.tolist()
        if not (all(map(math.isfinite, curvatures)) and all(map(math.isfinite, lengths))):
            return ""  # a broken path has no word
        ripple = RIPPLE * max(map(abs, curvatures), default=0.0)
        pieces = (
            (_side(k, ripple), abs(k) * length, length)
            for k, length in zip(curvatures, lengths, strict=True)
        )
        runs = [(side * (bend > tolerance), bend, length) for side, bend, length in _joined(pieces)]
        least = tolerance * self.length
        # a straight that is left out may have stood between two equal letters
        letters = (_LETTERS[side] for side, _, length in _joined(runs) if side or length > least)
        return "".join(letter for letter, _ in groupby(letters))


def corners(start: Pose, curvatures: FloatArray, lengths: FloatArray) -> FloatArray:
    """Poses at the ends of constant-curvature arcs.

    The arcs are driven one after another; row 0 is `start`. An arc of curvature k and length l
    turns the heading by k l. Its chord is l sinc(k l / 2) long and points along the mean heading.
    This is exact for the Dubins car, k = 0 included (LaValle 2006, Planning Algorithms, sec.
    15.3.1; docs/derivation.md, eq. 2). Headings are not wrapped. From the first heading that is not
    finite on, no pose is finite.

    Args:
        start: initial pose.
        curvatures: shape (n,), 1 / length unit, positive to the left.
        lengths: shape (n,), length unit.

    Returns:
        Shape (n + 1, 3).
    """
    if lengths.size <= _LOOPED:
        return np.array(_few_corners(start, curvatures, lengths))
    return _many_corners(start, curvatures, lengths)


def end_of(start: Pose, curvatures: FloatArray, lengths: FloatArray) -> Pose:
    """Pose at the end of the last arc.

    It is the last row of `corners`.
    """
    if lengths.size <= _LOOPED:
        return _few_corners(start, curvatures, lengths)[-1]
    return Pose(*_many_corners(start, curvatures, lengths)[-1].tolist())


def _few_corners(start: Pose, curvatures: FloatArray, lengths: FloatArray) -> list[Pose]:
    """Compute `corners` of few arcs, in a loop."""
    cos = math.cos(start.heading)
    sin = math.sin(start.heading)
    turned = forward = left = 0.0
    poses = [start]
    for k, s in zip(curvatures.tolist(), lengths.tolist(), strict=True):
        turn = k * s
        turned += turn
        half = turn / 2 or 1e-20  # sin(x) / x is 1 there
        # in the start's frame, since an angle added to a heading of many turns loses its digits
        middle = turned - turn / 2
        if not math.isfinite(middle):
            forward = left = half = middle = math.nan
        chord = s * (math.sin(half) / half)
        forward += chord * math.cos(middle)
        left += chord * math.sin(middle)
        x = start.x + (forward * cos - left * sin)
        y = start.y + (forward * sin + left * cos)
        poses.append(Pose(x, y, start.heading + turned))
    return poses


@np.errstate(all="ignore")  # headings that are not finite
def _many_corners(start: Pose, curvatures: FloatArray, lengths: FloatArray) -> FloatArray:
    """Compute `corners` of many arcs, in whole arrays."""
    cos = math.cos(start.heading)
    sin = math.sin(start.heading)
    turn = curvatures * lengths
    turned = turn.cumsum()
    chord = _chord(turn, lengths)
    middle = turned - turn / 2
    forward = (chord * np.cos(middle)).cumsum()
    left = (chord * np.sin(middle)).cumsum()
    x = start.x + (forward * cos - left * sin)
    y = start.y + (forward * sin + left * cos)
    return np.vstack([start, np.column_stack((x, y, start.heading + turned))])


def _chord(turn: FloatArray, length: FloatArray) -> FloatArray:
    """Lengths of arcs' chords, from turns and lengths.

    Turns are in rad; shapes (m,), (m,) -> (m,).
    """
    half = turn / 2
    half[half == 0] = 1e-20  # sin(x) / x is 1 there
    chord: FloatArray = length * (np.sin(half) / half)
    return chord


def _advance(poses: FloatArray, curvature: FloatArray, length: FloatArray) -> FloatArray:
    """Move each pose along its arc.

    Shapes (m, 3), (m,), (m,) -> (m, 3).
    """
    turn = curvature * length
    chord = _chord(turn, length)
    middle = poses[:, 2] + turn / 2
    step = np.column_stack((chord * np.cos(middle), chord * np.sin(middle), turn))
    moved: FloatArray = poses + step
    return moved


def outline(path: Path, angle: float = 0.05) -> tuple[FloatArray, FloatArray]:
    """Poses that cut a path's arcs into equal parts.

    Args:
        path: with finite numbers; an arc of negative length is left out.
        angle: largest turn of a part (rad); more for paths of thousands of turns. A chord over
            0.05 rad is 0.0003 radii from its arc.

    Returns:
        Poses at the ends of the m parts, shape (m + 1, 3), and their curvatures, shape (m,).
    """
    driven = path.lengths > 0
    curvatures = path.curvatures[driven]
    lengths = path.lengths[driven]
    turn = np.abs(curvatures) * lengths
    angle = max(angle, turn.sum() / _MOST_PARTS)
    parts = np.maximum(np.ceil(turn / angle), 1.0).astype(int)
    return path.at(_cuts(lengths, parts)), curvatures.repeat(parts)


def _cuts(lengths: FloatArray, parts: NDArray[np.int_]) -> FloatArray:
    """Distances that cut arcs into equal parts.

    `parts` is the number of parts of each arc. The distances go from 0 to the end of the path,
    shape (parts.sum() + 1,).
    """
    ends = lengths.cumsum()
    # of each part: its number within its arc, and where the arc begins
    place = np.arange(parts.sum()) - (parts.cumsum() - parts).repeat(parts)
    begins = (ends - lengths).repeat(parts)
    return np.append(begins + place * (lengths / parts).repeat(parts), ends[-1:].sum())


_LETTERS = {1: "L", -1: "R", 0: "S"}  # by the side of `_side`


def _side(curvature: float, ripple: float) -> int:
    """Side: 1 left, -1 right, 0 straight."""
    if abs(curvature) <= ripple:
        return 0
    if curvature > 0:
        return 1
    return -1


def _joined(pieces: Iterable[Piece]) -> list[Piece]:
    """Merge neighbouring pieces of the same side.

    A merged piece has the sum of their turns and of their lengths.
    """
    joined: list[Piece] = []
    for side, bend, length in pieces:
        if joined and joined[-1][0] == side:
            _, bent, driven = joined[-1]
            joined[-1] = side, bent + bend, driven + length
        else:
            joined.append((side, bend, length))
    return joined


def drivable(path: Path) -> bool:
    """Whether a path can be driven.

    All numbers and their sums must be finite, and no length negative.
    """
    curvatures = path.curvatures.tolist()
    lengths = path.lengths.tolist()
    turned = sum(map(mul, curvatures, lengths))
    sums = sum(curvatures), sum(lengths), turned, *path.start
    return all(map(math.isfinite, sums)) and min(lengths, default=0.0) >= 0


@dataclass(frozen=True, eq=False)
class Paths:
    """Controls of n paths, one a row.

    A path has at most two or three arcs and starts at its scenario's start.

    Args:
        curvatures: shape (2, n) or (3, n), 1 / length unit, positive to the left.
        lengths: of the same shape, length unit; an arc of length 0 is left out.
        returned: shape (n,), False where there is no path; None if all rows have one.
    """

    curvatures: FloatArray
    lengths: FloatArray
    returned: BoolArray | None = None

    def __post_init__(self) -> None:
        # zeros stand for missing axes, so that `real_array` refuses the shape
        arcs, n = (*np.shape(self.curvatures), 0, 0)[:2]
        if arcs != 3:
            arcs = 2
        for name in ("curvatures", "lengths"):
            array = real_array(name, getattr(self, name), (arcs, n))
            object.__setattr__(self, name, array)
        if self.returned is not None:
            returned = np.asarray(self.returned)
            if returned.shape != (n,) or returned.dtype != np.bool_:
                actual = f"of {returned.dtype}, shape {returned.shape}"
                raise TypeError(f"returned is an array {actual}; expected booleans, shape {(n,)}")
            object.__setattr__(self, "returned", returned)

    def __len__(self) -> int:
        return int(self.curvatures.shape[-1])

    def path(self, row: int, scenario: Scenario) -> Path | None:
        """Path of one row, for the scalar check.

        None if the row has no path.
        """
        if self.returned is not None and not self.returned[row]:
            return None
        driven = self.lengths[:, row] != 0
        return Path(scenario.start, self.curvatures[driven, row], self.lengths[driven, row])
