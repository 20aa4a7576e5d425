"""A small run, and canaries for executed data.

A canary sings if code from data is run.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from dubins_study import run

_CANARY = """
from pathlib import Path
Path({song!r}).touch()
class Canary: pass
"""
_SMALL = """
title = "small"
question = "is it read?"
solvers = ["analytic"]
[[scenarios]]
target_x = { linear = [2, 5, 4] }
target_y = 3
[[scenarios]]
label = "many"
target_x = { linear = [2, 5, 120] }
target_y = -3
"""


@pytest.fixture(scope="module")
def song(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with a plug-in and a program.

    They are `canary.py` and `canary`; the folder is on PATH. Whichever runs leaves a file. The
    folder is the working directory, and must not change.
    """
    cage = tmp_path_factory.mktemp("cage")
    left = tmp_path_factory.mktemp("song") / "sung"
    (cage / "canary.py").write_text(_CANARY.format(song=str(left)))
    for name in ("canary", "ipopt"):
        (cage / name).write_text(f"#!/bin/sh\ntouch {left}\n")
        (cage / name).chmod(0o755)
    patch = pytest.MonkeyPatch()
    patch.setenv("PATH", str(cage), prepend=":")
    patch.chdir(cage)
    contents = sorted(cage.iterdir())
    yield left
    patch.undo()
    assert sorted(cage.iterdir()) == contents


class SmallRun(NamedTuple):
    """A finished run and its experiment."""

    folder: Path
    experiment: Path


@pytest.fixture(scope="session")
def small_run(tmp_path_factory: pytest.TempPathFactory) -> SmallRun:
    """A run of some cells of the closed form."""
    place = tmp_path_factory.mktemp("small")
    experiment = place / "small.toml"
    experiment.write_text(_SMALL)
    return SmallRun(run(experiment, place / "out"), experiment)
