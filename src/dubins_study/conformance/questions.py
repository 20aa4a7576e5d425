"""The labelled scenarios of the checks.

Commands that ask them again are here too. Radii, speeds, start poses and headings differ from 1 and
0 one after another: the questions that fail show which of them a solver mixes up.
"""

from __future__ import annotations

import cmath
import math
import shlex
from collections.abc import Mapping
from dataclasses import replace

from dubins_study.solvers.protocol import Question
from dubins_study.study.kinds.leg import LEG
from dubins_study.study.kinds.table import EVERY_KIND
from dubins_study.study.scenario import COLUMNS, Scenario
from dubins_study.study.scenario_frame import solve_command

TIME_LIMIT_S = 5.0  # for one question, unless the caller gives another


def labelled(scenarios: Mapping[str, Scenario]) -> dict[str, Scenario]:
    """The scenarios with their names as labels.

    Findings name the scenarios by their labels.
    """
    return {name: replace(scenario, label=name) for name, scenario in scenarios.items()}


# General positions, outside both turning discs: the shortest path is LS or RS.
GENERAL = labelled(
    {
        "target ahead to the left": Scenario(target_x=3, target_y=2),
        "target behind to the right": Scenario(target_x=-4, target_y=-3),
        "radius 2.5": Scenario(target_x=7, target_y=4, radius=2.5),
        "radius 0.4": Scenario(target_x=2, target_y=-1.5, radius=0.4),
        "heading 1.1 rad": Scenario(heading=1.1, target_x=-4, target_y=3),
        "start at (2, -1)": Scenario(2, -1, target_x=6, target_y=4),
        "speed 3": Scenario(target_x=3, target_y=-2, speed=3),
        "all at once": Scenario(-3, 4, 2.2, 5, 8.5, 0.4, 0.6),
        "all at once, other side": Scenario(2, -1, -0.5, -9, 6, 2.5, 3),
    }
)
# One question in general position that the other checks change.
REFERENCE = GENERAL["all at once"]


def placed(X: float, Y: float, label: str = "") -> Scenario:
    """The reference with another target.

    The target lies X radii ahead of the start and Y radii to the left.
    """
    s = REFERENCE
    offset = s.radius * complex(X, Y) * cmath.rect(1, s.start.heading)
    target = complex(s.x, s.y) + offset
    return replace(s, target_x=target.real, target_y=target.imag, label=label)


# The reference with its target a little farther.
NEAR = placed(1.01 * REFERENCE.local()[0], 1.01 * REFERENCE.local()[1])
DISCS = labelled(
    {
        "centre of the left disc": Scenario(target_x=0, target_y=1),
        "centre of the right disc": Scenario(target_x=0, target_y=-1),
        "in the left disc": placed(0.3, 1.2),
        "in the right disc": placed(0.3, -1.2),
        "rear of the left disc": placed(-0.5, 1.2),
        "rear of the right disc": placed(-0.5, -1.2),
    }
)


def _near_circle(angle: float, distance: float) -> Scenario:
    """A target near the left circle.

    `angle` (rad) is the arc along the circle from the start. The target lies `distance` radii
    outside the circle, or inside if that is negative.
    """
    target = complex(0, 1) + cmath.rect(1 + distance, angle - math.pi / 2)
    return Scenario(target_x=target.real, target_y=target.imag)


_FRONT = 1.0  # arc angle (rad) of the left circle
_REAR = 4.5
CIRCLES = labelled(
    {
        "on the left circle, (R, R)": Scenario(target_x=1, target_y=1),
        "on the left circle, (0, 2R)": Scenario(target_x=0, target_y=2),
        "on the right circle, (-R, -R)": Scenario(target_x=-1, target_y=-1),
        "0.01 R outside the left circle's front": _near_circle(_FRONT, 1e-2),
        "0.0001 R outside the left circle's front": _near_circle(_FRONT, 1e-4),
        "0.01 R inside the left circle's front": _near_circle(_FRONT, -1e-2),
        "0.0001 R inside the left circle's front": _near_circle(_FRONT, -1e-4),
        "0.01 R outside the left circle's rear": _near_circle(_REAR, 1e-2),
        "0.0001 R outside the left circle's rear": _near_circle(_REAR, 1e-4),
        "0.01 R inside the left circle's rear": _near_circle(_REAR, -1e-2),
        "0.0001 R inside the left circle's rear": _near_circle(_REAR, -1e-4),
    }
)
AXIS = labelled(
    {
        "straight ahead": Scenario(target_x=5, target_y=0),
        "straight behind": Scenario(target_x=-5, target_y=0),
        "just behind": Scenario(target_x=-0.1, target_y=0),
        "at the start": Scenario(3, -2, 1, 3, -2),
    }
)


def changed(turn: float = 0.0, shift: complex = 0j, scale: float = 1.0) -> Scenario:
    """The reference turned, then moved, then scaled.

    Start and target are turned by `turn` (rad) about the origin and moved by `shift`, x + iy. Then
    all lengths, the radius too, are multiplied by `scale`.
    """
    s = REFERENCE
    turned = cmath.rect(1, turn)
    start = scale * (complex(s.x, s.y) * turned + shift)
    target = scale * (complex(*s.stops[-1][:2]) * turned + shift)
    return replace(
        s,
        x=start.real,
        y=start.imag,
        heading=s.start.heading + turn,
        target_x=target.real,
        target_y=target.imag,
        radius=scale * s.radius,
    )


_HEADING = REFERENCE.start.heading
# changes that leave the length of the shortest path as it is
SYMMETRIES = labelled(
    {
        "in a mirror": replace(
            REFERENCE, y=-REFERENCE.y, heading=-_HEADING, target_y=-REFERENCE.stops[-1].y
        ),
        "moved by (100, -50)": changed(shift=100 - 50j),
        "turned by 2 rad": changed(turn=2.0),
        "heading a full turn more": replace(REFERENCE, heading=_HEADING + 2 * math.pi),
        "heading ten turns less": replace(REFERENCE, heading=_HEADING - 20 * math.pi),
        "the same target from elsewhere": replace(REFERENCE, x=8.0, y=5.5, heading=0.7),
    }
)
SCALES = labelled(
    {
        "a thousand times larger": changed(scale=1e3),
        "a thousand times smaller": changed(scale=1e-3),
        "a million times larger": changed(scale=1e6),
        "200 radii away": placed(190.0, -60.0),
        "ten times as fast": replace(REFERENCE, speed=10 * REFERENCE.speed),
    }
)

# questions of each kind, by its name
OF_KIND = {kind.name: labelled(kind.examples) for kind in EVERY_KIND} | {LEG.name: GENERAL}

# word -> questions that have a path of the word
WORDS = {
    word: tuple(placed(*at, f"{word}, question {n}") for n, at in enumerate(targets, 1))
    for word, targets in {
        "LS": ((3, 2), (4, -2), (-3, 1)),
        "RS": ((3, -2), (4, 2), (-3, -1)),
        "LR": ((0.3, -1.2), (2, 1.5), (-1, -0.2)),
        "RL": ((0.3, 1.2), (2, -1.5), (-1, 0.2)),
    }.items()
}
# word -> a question that has no path of the word: in the disc that the turn goes around, or too far
WITHOUT = {
    word: placed(*target, f"{word}, which has no path here")
    for word, target in {"LS": (0.2, 1), "RS": (0.2, -1), "LR": (9, 2), "RL": (9, -2)}.items()
}


def command(spec: str, question: Question, limit: float, profile: str) -> str:
    """The command that asks a question again.

    The command has the same limit (s) and profile.
    """
    row = {name: getattr(question.scenario, name) for name in COLUMNS}
    row |= {"solver": spec, "branch": question.branch, "profile": profile, "time_limit_s": limit}
    return solve_command(row)


def check_command(spec: str, check: str, limit: float, profile: str) -> str:
    """The command that makes a check again.

    Findings that no single question shows have this command.
    """
    words = ["dubins-study", "check-solver", spec, "--check", check]
    if limit != TIME_LIMIT_S:
        words += ["--time-limit", f"{limit:g}"]
    if profile != "default":
        words += ["--profile", profile]
    return shlex.join(words)
