"""Results folders from strangers: read, refused or mended, and shown as mere text."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import dubins_study.report.page.render  # noqa: F401  its libraries write to places of their own when loaded
from tests.fuzz.damage import spoil
from tests.fuzz.hostile import cases
from tests.fuzz.page import check_json, check_report
from tests.fuzz.watched import command, raw_controls, temporary_files_in, watched


def answered_or_refused(words: tuple[str, ...], inside: Path, song: Path) -> int:
    """The exit code; nothing but clean words is said, and nothing is written elsewhere."""
    with watched() as seen, temporary_files_in(inside):
        said = command(*words)
    assert said.code in (0, 2), said.err
    assert "Traceback" not in said.err
    assert not raw_controls(said.out)
    # a bar that moves is drawn with such characters
    told = [line for line in said.err.split("\n") if line.startswith("dubins-study")]
    assert not raw_controls("".join(told))
    if said.code == 2:
        assert not said.out
        assert re.search(r"^dubins-study: [^\n]+\n(  [^\n]+\n)*\Z", said.err, re.MULTILINE)
        # what was mended before is told, too
        assert all(line.startswith(("dubins-study: ", "  ")) for line in said.err.splitlines())
        assert not raw_controls(said.err)
    elif "--json" in words:
        check_json(said.out)
    assert not song.exists()
    # a run's own workers answer it in pickles, and compiled kernels are kept as such
    assert words[0] == "run" or not [n for n in seen.unpickled if "numba" not in n]
    assert not seen.outside(inside)
    return said.code


@pytest.fixture(scope="module")
def spoilt(small_run, tmp_path_factory):
    """Makes a spoilt copy of the small run, in a folder of its own."""
    place, number = tmp_path_factory.mktemp("spoilt"), 0

    def make(seed: int) -> Path:
        nonlocal number
        number += 1
        shutil.rmtree(place / str(number - 1), ignore_errors=True)
        folder = place / str(number) / "out"
        shutil.copytree(small_run.folder, folder)
        spoil(folder, seed)
        return folder

    return make


seeds = st.integers(0, 2**32 - 1)


def looked_at(seed, spoilt, small_run, song):
    folder = spoilt(seed)
    around = sorted(folder.parent.iterdir())
    answered_or_refused(("status", str(folder)), folder.parent, song)
    answered_or_refused(("status", "--json", str(folder)), folder.parent, song)
    union = folder.parent / "union"
    for given_folders in ([small_run.folder, folder], [folder, small_run.folder]):
        words = ("merge", *map(str, given_folders), "--out", str(union))
        if answered_or_refused(words, folder.parent, song) == 0:
            answered_or_refused(("status", str(union)), folder.parent, song)
            shutil.rmtree(union)
        assert sorted(folder.parent.iterdir()) == around


def reported(seed, spoilt, song):
    folder = spoilt(seed)
    out = folder.parent / "report"
    if answered_or_refused(("report", str(folder), "--out", str(out)), folder.parent, song) == 0:
        check_report(out)
    else:
        assert not out.exists()


def resumed(seed, spoilt, small_run, song):
    folder = spoilt(seed)
    words = ("run", str(small_run.experiment), "--out", str(folder))
    if answered_or_refused(words, folder.parent, song) == 0:
        answered_or_refused(words, folder.parent, song)
    answered_or_refused(("status", str(folder)), folder.parent, song)


@cases(25)
@given(seed=seeds)
def test_a_spoilt_folder_is_looked_at(seed, spoilt, small_run, song):
    looked_at(seed, spoilt, small_run, song)


@pytest.mark.slow
@cases(6)
@given(seed=seeds)
def test_a_spoilt_folder_is_reported(seed, spoilt, song):
    reported(seed, spoilt, song)


@cases(8)
@given(seed=seeds)
def test_a_spoilt_folder_is_resumed(seed, spoilt, small_run, song):
    resumed(seed, spoilt, small_run, song)


@pytest.mark.slow
@pytest.mark.timeout(1800)  # these three take minutes of a quiet core
@cases(400)
@given(seed=seeds)
def test_hundreds_of_spoilt_folders_are_looked_at(seed, spoilt, small_run, song):
    looked_at(seed, spoilt, small_run, song)


@pytest.mark.slow
@pytest.mark.timeout(1800)
@cases(100)
@given(seed=seeds)
def test_hundreds_of_spoilt_folders_are_reported(seed, spoilt, song):
    reported(seed, spoilt, song)


@pytest.mark.slow
@pytest.mark.timeout(1800)
@cases(100)
@given(seed=seeds)
def test_hundreds_of_spoilt_folders_are_resumed(seed, spoilt, small_run, song):
    resumed(seed, spoilt, small_run, song)
