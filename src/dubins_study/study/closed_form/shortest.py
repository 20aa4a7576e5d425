"""Closed form for one scenario.

It gives the shortest path of every word, and the shortest of all. Everything is in the vehicle's
frame in units of the radius: target (X, Y), X forward, Y to the left (docs/derivation.md, sections
1 and 3 to 6). `study.closed_form.kernel` does the same for arrays.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from dubins_study.study.angle import TWO_PI
from dubins_study.study.body_coordinates import Local, local, power
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.words import TURN


class Shortest(NamedTuple):
    """Shortest path of a branch.

    `word` has the letters whose segments have a length; `segments` has the others too, as zeros.
    Segments are in units of the radius (for an arc: its angle in rad). `words` are the words of all
    paths that are as short, `word` first.
    """

    word: str
    segments: tuple[float, ...]
    words: tuple[str, ...]

    @property
    def total(self) -> float:
        return sum(self.segments)


# Python runs the next five functions for one target; `kernel` compiles the same functions for
# arrays. So they take and return plain numbers: X, Y and delta of a `Local`.


def best_segments(X: float, y: float, delta: float) -> tuple[float, float, bool]:
    """Segments (radii) of the shortest path of all.

    y is |Y|. The flag says whether the word is RL; otherwise it is LS. A target within delta / 2 of
    the start or of the axis ahead, or on the circle by `power`, is taken to be there.
    """
    if power(X, y, delta) > 0.0:
        first, second, _, _ = right_left_pair(X, y, delta)
        return first, second, True
    first, second = left_straight(X, y, delta)
    return first, second, False


def left_straight(X: float, Y: float, delta: float) -> tuple[float, float]:
    """Arc (rad) and straight (radii) of shortest LS.

    Both are NaN inside the left disc.
    """
    if abs(Y) <= 0.5 * delta and -0.5 * delta <= X:
        return 0.0, X if 0.5 * delta < X else 0.0  # ahead, or at the start
    w = power(X, Y, delta)
    if w > 0.0:
        return math.nan, math.nan
    s = math.sqrt(-w)
    if s == 0.0:  # on the circle: the arc's angle at its centre
        a = math.atan2(X, 1.0 - Y)
    else:  # two forms of tan(a/2), each free of cancellation on its side
        a = 2.0 * math.atan2(Y, X + s) if X >= 0.0 else 2.0 * math.atan2(s - X, Y - 2.0)
    return a if a >= 0.0 else a + TWO_PI, s


def right_left(X: float, Y: float, delta: float) -> tuple[float, float]:
    """Both arcs (rad) of the shortest RL path.

    NaN unless the target is 1 to 3 radii from the right circle's centre.
    """
    a, b, other_a, other_b = right_left_pair(X, Y, delta)
    return (other_a, other_b) if other_a + other_b < a + b else (a, b)


def right_left_pair(X: float, Y: float, delta: float) -> tuple[float, float, float, float]:
    """Arcs (rad) of both RL paths.

    The path whose second arc is above pi comes first; the paths are equal where the second arc is
    pi. At the edges of the word's reach, and where a first arc vanishes, the lengths go like the
    root of a distance or jump. A target within about delta / 2 of them is taken to be there.
    """
    if abs(X) <= 0.5 * delta and abs(Y) <= 0.5 * delta:
        return 0.0, TWO_PI, 0.0, 0.0
    w = power(X, Y, delta)
    p = X * X + Y * (Y + 2.0)  # |T - C_R|^2 - 1
    q = 4.0 * (2.0 - Y) + w  # 9 - |T - C_R|^2
    bearing = math.atan2(X, 1.0 + Y)  # of T from C_R, from straight up, clockwise as R turns
    # on the left circle: one path is the arc to T, the other's second arc is the rest of the turn
    if w == 0.0:
        arc = math.atan2(X, 1.0 - Y)
        arc = arc if arc >= 0.0 else arc + TWO_PI
        turn = wrapped(2.0 * bearing)
        return (0.0, arc, turn, TWO_PI - arc) if arc > math.pi else (turn, TWO_PI - arc, 0.0, arc)
    if abs(p) <= delta:  # on the right circle
        return wrapped(bearing), TWO_PI, wrapped(bearing), 0.0
    if abs(q) <= 3.0 * delta:  # as far as RL reaches
        return wrapped(bearing), math.pi, wrapped(bearing), math.pi
    if p < 0.0 or q < 0.0:
        return math.nan, math.nan, math.nan, math.nan
    A = p + 4.0 * Y + 8.0
    D = math.sqrt(p * q)  # 16 X^2 + A w, 4 x the area of C_R, second centre, T
    bend = 2.0 * math.atan2(math.sqrt(p), math.sqrt(q))
    if A > 1.0:
        # the roots of A t^2 - 8 X t - w = 0 with t = tan(a1/2), each in its stable form
        plus = 2.0 * (math.atan2(4.0 * X + D, A) if X >= 0.0 else math.atan2(w, D - 4.0 * X))
        minus = 2.0 * (math.atan2(4.0 * X - D, A) if X < 0.0 else math.atan2(-w, D + 4.0 * X))
    else:
        # A and X vanish at (0, -2) and (0, -4); there: the bearing and the angle between T and the
        # second circle's centre
        between = math.atan2(D, p + 4.0)
        plus, minus = bearing + between, bearing - between
    return wrapped(plus), TWO_PI - bend, wrapped(minus), bend


def wrapped(angle: float) -> float:
    """Angle (rad) brought to [0, 2 pi].

    An angle just below zero is a full turn.
    """
    return angle % TWO_PI


def shortest_local(target: Local, branch: str = "best") -> Shortest | None:
    """Shortest path of a branch to a target.

    None where the branch has none. The only tie of two different paths is straight behind; there LS
    is chosen.
    """
    if branch in ("RS", "LR"):  # LS and RL to the mirror image
        target = target.mirrored
    X, Y, delta = target
    if branch != "best":
        segments_of = right_left
        if branch in ("LS", "RS"):
            segments_of = left_straight
        segments = segments_of(X, Y, delta)
        if math.isnan(segments[0]):
            return None
        return named(branch, segments)
    on_axis = abs(Y) <= 0.25 * delta  # as in `chosen_side`
    first, second, arcs_only = best_segments(X, abs(Y), delta)
    letters = "LS"
    if arcs_only:
        letters = "RL"
    if not chosen_side(Y, delta):
        letters = {"LS": "RS", "RL": "LR"}[letters]
    shortest = named(letters, (first, second))
    if not (on_axis and first > 0.0):
        return shortest
    # straight behind the mirror image is as short
    return shortest._replace(words=(shortest.word, shortest.word.replace("L", "R")))


def chosen_side(Y: float, delta: float) -> bool:
    """Whether the shortest path turns left first.

    A target on the axis counts as on the left, and so does one within delta / 4 to the right. The
    path to the latter is its mirror image's, which ends within delta / 2 of the target.
    """
    return -0.25 * delta <= Y


def named(letters: str, segments: tuple[float, ...]) -> Shortest:
    """Path of a word, its empty letters dropped.

    Letters whose segments have no length do not appear in the word.
    """
    word = "".join(c for c, length in zip(letters, segments, strict=True) if length > 0)
    return Shortest(word, segments, (word,))


def shortest(scenario: Scenario, branch: str = "best") -> Shortest | None:
    """Shortest path of a scenario's branch.

    Segments are in units of the radius.
    """
    return shortest_local(local(scenario), branch)


def shortest_path(scenario: Scenario, branch: str = "best") -> Path | None:
    """Shortest path of a scenario, as controls.

    None where the branch has none.
    """
    optimum = shortest(scenario, branch)
    if optimum is None:
        return None
    return as_path(scenario.start, scenario.radius, optimum.word, optimum.segments)


def as_path(start: Pose, radius: float, word: str, segments: tuple[float, ...]) -> Path:
    """Path with the controls of a word.

    Segments of no length are left out, as their letters are.
    """
    driven = [length * radius for length in segments if length > 0]
    return Path(start, [TURN[letter] / radius for letter in word], driven)


REGIONS = ("outside", "left disc", "right disc", "circle")
OUTSIDE, LEFT_DISC, RIGHT_DISC, CIRCLE = REGIONS


def region_of(left: float, right: float) -> str:
    """Target's region, one of `REGIONS`.

    The arguments are w of the left and of the right disc.
    """
    if left > 0:
        return LEFT_DISC
    if right > 0:
        return RIGHT_DISC
    if left == 0 or right == 0:
        return CIRCLE
    return OUTSIDE


def margin_local(X: float, y: float) -> float:
    """Distance of the target from the turning circle.

    It is | |T - C| - 1 |, computed as |w| / (1 + |T - C|), which keeps its digits near the circle;
    y = |Y|.
    """
    return abs(y * (2.0 - y) - X * X) / (1.0 + math.hypot(X, y - 1.0))
