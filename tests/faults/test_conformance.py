"""The conformance kit finds hostile plug-ins.

Each is a finding, in plain text.
"""

import re

import pytest

from dubins_study import check_solver
from dubins_study.conformance.report import Status
from tests.plugin_files import spec

# plug-in -> the check that finds it, and words of what it says
HOSTILE = {
    "hostile:Unprintable": ("outcome", "SIGABRT; its last output: .*alert"),
    "hostile:CrashInUnavailable": ("loading", "while it was loaded, .* SIGABRT"),
    "hostile_answers:RaisesInterrupt": ("outcome", "KeyboardInterrupt: from inside"),
    "hostile_answers:RaisesSpeechless": ("outcome", "raised Speechless"),
    "hostile_answers:RaisesMarkup": ("outcome", "OSError"),
    "hostile_memory:OutOfMemory": ("outcome", "tree of nodes does not fit"),
}


@pytest.mark.many(3)
@pytest.mark.parametrize("name", HOSTILE)
def test_whatever_a_plugin_does_is_a_finding(name):
    check, words = HOSTILE[name]
    report = check_solver(spec(*name.split(":")), checks=["outcome", check], time_limit=5)

    assert report[check].status is Status.FAIL, report
    message = " ".join(f"{one.observed} {one.advice}" for one in report[check].findings)
    assert re.search(words, message, re.DOTALL), report
    assert all(character.isprintable() or character == "\n" for character in str(report))
