"""Peers of routes, built from their public sources.

They are comrob/gdip (bounds) and icosac/MPDP (paths).

`python -m benchmarks route --peers FOLDER` finds clones of them in FOLDER/gdip and FOLDER/MPDP.
A program of ours around each library is compiled in a temporary folder and put the routes that our
search has answered. Their paths are judged by the headings, not by the lengths that they report.
"""

from __future__ import annotations

import atexit
import subprocess
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from shutil import rmtree, which
from statistics import median
from tempfile import mkdtemp
from typing import NamedTuple

import numpy as np

from benchmarks import harness
from benchmarks.harness import Measurement, absent
from dubins_study.study.arrays import FloatArray
from dubins_study.study.route.descent import route_length
from dubins_study.study.route.search import Route
from dubins_study.study.tolerances import ARRIVES

HERE = Path(__file__).parent
NO_SOURCES = "no sources: --peers FOLDER with clones of comrob/gdip and icosac/MPDP"
ROUNDING = 1e-12  # between lengths of one path in the arithmetic of two programs


class Peer(NamedTuple):
    """A library and its settings.

    It has the parts of its clone that are compiled.
    """

    name: str  # also of the clone's folder
    includes: tuple[str, ...]
    sources: str  # a pattern
    settings: tuple[tuple[str, str], ...]  # what the table shows; what the program reads first


# The finest resolution in gdip's examples is 64. MPDP's test program has 4, 16, 90 and 360 headings
# a point, and 1 to 16 refinements.
PEERS = (
    Peer(
        "gdip",
        ("gdip/core/src",),
        "gdip/core/src/opendubins/*.cpp",
        tuple((f"resolution {n}", f"{n} {{limit}}") for n in (64, 1024, 16384)),
    ),
    Peer(
        "MPDP",
        ("srcCC/include", "include"),
        "srcCC/*[!t].cc",  # not asyplot.cc, which draws
        tuple((f"{k} headings, 16 refinements", f"{k} 16") for k in (16, 90)),
    ),
)


class Answer(NamedTuple):
    """What a peer says about a route."""

    seconds: float
    low: float  # 0 where it has no bound
    length: float  # of its path, as it reports it
    headings: FloatArray
    reached: float  # the resolution, where the time was over before the one that was asked for


def peer_rows(
    points: Sequence[FloatArray],
    ours: Sequence[Route],
    first: float,
    limit: float,
    tolerance: float,
) -> Iterable[Measurement]:
    """A row for each peer and setting.

    They answer the routes that `ours` answers. None without sources.
    """
    for peer in PEERS if harness.peer_sources else ():
        try:
            program = _built(harness.peer_sources, peer)
            for shown, setting in peer.settings:
                head = f"{setting.format(limit=limit)} {first!r}"
                answers = _ask(program, head, points)
                yield _row(f"  {peer.name}, {shown}", points, answers, ours, tolerance)
        except (FileNotFoundError, subprocess.CalledProcessError) as error:
            yield absent(f"  {peer.name}", str(error))


@cache
def _built(clones: Path, peer: Peer) -> Path:
    """The program around a peer, compiled."""
    clone = clones / peer.name
    sources = sorted(clone.glob(peer.sources))
    if not sources:
        raise FileNotFoundError(f"no file {clone / peer.sources}")
    if which("g++") is None:
        raise FileNotFoundError("no compiler g++")
    program = Path(mkdtemp()) / peer.name
    atexit.register(rmtree, program.parent)
    driver = HERE / f"route_{peer.name.lower()}.cpp"
    # gdip's own flags; without OpenMP, MPDP runs in one thread
    flags = ["-O3", "-std=c++11", "-w", *(f"-I{clone / folder}" for folder in peer.includes)]
    subprocess.run(["g++", *flags, *sources, driver, "-o", program], check=True)
    return program


def _ask(program: Path, head: str, points: Sequence[FloatArray]) -> list[Answer]:
    """The program's answers; all routes in one process."""
    asked = [f"{head} {len(some)} {' '.join(map(repr, some.ravel().tolist()))}" for some in points]
    done = subprocess.run(
        [program], input="\n".join(asked), capture_output=True, text=True, check=True
    )
    lines = (np.array(line.split(), np.float64) for line in done.stdout.splitlines())
    return [Answer(*row[:3].tolist(), row[3:-1], float(row[-1])) for row in lines]


def _row(
    what: str,
    points: Sequence[FloatArray],
    answers: Sequence[Answer],
    ours: Sequence[Route],
    tolerance: float,
) -> Measurement:
    """A peer's time, bounds and paths beside ours.

    Its time stands beside ours; bounds and paths stand beside the proven interval.
    """
    lengths = np.array(
        [
            route_length(np.ascontiguousarray(np.diff(some, axis=0)), answer.headings)
            for some, answer in zip(points, answers, strict=True)
        ]
    )
    _, low, reported, _, reached = zip(*answers, strict=True)
    our_low, best, our_high = np.array([(r.low, r.length, r.high) for r in ours]).T
    longer = lengths / best - 1.0
    notes = []
    if any(low):
        gaps = 1.0 - np.array(low) / lengths
        notes.append(f"gap {median(gaps):.0e}, at most {gaps.max():.0e}")
        if min(reached) < max(reached):
            notes.append(f"time over at resolution {min(reached):.0f}")
    notes.append(f"path {median(longer):.0e}, at most {longer.max():.0e} longer than ours")
    notes.append(f"{(longer <= tolerance).sum()} of {len(answers)} within {tolerance:g}")
    findings = {
        "bounds above our path": np.array(low) > our_high * (1.0 + ROUNDING),
        "paths below our bound": lengths < our_low * (1.0 - ROUNDING),
        # more than a miss by the tolerance of arriving
        "lengths reported too short": np.array(reported) < lengths - ARRIVES,
    }
    notes += [f"{wrong.sum()} {name}" for name, wrong in findings.items() if wrong.any()]
    theirs, seconds = (median(some.seconds for some in every) for every in (answers, ours))
    return Measurement(
        what, ours=seconds, peer=theirs, unit="s", ratio=theirs / seconds, note="; ".join(notes)
    )
