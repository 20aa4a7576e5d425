"""Hostile plug-ins through the conformance kit: each is a finding, in plain text."""

from __future__ import annotations

import re

import psutil
import pytest

from dubins_study import check_solver
from dubins_study.conformance.report import Status
from tests.faults.launch import spec

# plug-in -> the check that finds it, and words of what it says
HOSTILE = {
    "hostile:Segfault": ("outcome", "ended by SIGSEGV"),
    "hostile:Unprintable": ("outcome", "SIGABRT; its last output: .*alert"),
    "hostile:CrashInUnavailable": ("loading", "while it was loaded, .* SIGABRT"),
    "hostile_answers:RaisesInterrupt": ("outcome", "KeyboardInterrupt: from inside"),
    "hostile_answers:RaisesSpeechless": ("outcome", "raised Speechless"),
    "hostile_answers:RaisesMarkup": ("outcome", "OSError"),
    "hostile_answers:Easier": ("controls", "the curvature is 1 / R beyond"),
    "hostile_answers:WritesFile": ("state", "left-by-a-solver"),
    "hostile_memory:OutOfMemory": ("outcome", "tree of nodes does not fit"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_whatever_a_plugin_does_is_a_finding(name):
    check, words = HOSTILE[name]
    report = check_solver(spec(*name.split(":")), checks=["outcome", check], time_limit=5)

    assert report[check].status is Status.FAIL, report
    found = " ".join(f"{one.observed} {one.advice}" for one in report[check].findings)
    assert re.search(words, found, re.DOTALL), report
    assert all(character.isprintable() or character == "\n" for character in str(report))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["LoopInC", "OwnSession"])
def test_a_plugin_that_never_returns_is_ended(name):
    """Three questions are asked, and none of its processes is left."""
    before = {child.pid for child in psutil.Process().children(recursive=True)}
    report = check_solver(spec("hostile_endless", name), time_limit=0.5)

    assert report["outcome"].status is Status.FAIL, report
    assert "it did not return" in report["outcome"].findings[0].observed
    assert sum(report.answers.values()) == 3
    workers = [
        child
        for child in psutil.Process().children(recursive=True)
        if child.pid not in before and child.status() != psutil.STATUS_ZOMBIE
    ]
    assert len(workers) <= 1  # the fork server


@pytest.mark.slow
@pytest.mark.parametrize("name", ["hostile_answers:Wordy", "hostile_state:Floods"])
def test_what_a_plugin_prints_or_says_at_length_does_no_harm(name):
    report = check_solver(spec(*name.split(":")), checks=["outcome"])

    assert report["outcome"].passed, report
    assert len(str(report)) < 10_000
