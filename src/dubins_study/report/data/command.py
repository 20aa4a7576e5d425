"""The columns that ask a row's question again, and the command that asks all of a run's."""

from __future__ import annotations

import shlex

from dubins_study.study.rows.manifest import Manifest
from dubins_study.study.scenario import VIA

SCENARIO = ("x", "y", "heading", "target_x", "target_y", "radius")
ROUTE = (*VIA, "final_heading")


# Options of a run that say who answers its questions, and how many at once: with their values.
_OF_ANSWERS = ("--solver", "--jobs", "--executor", "--engine")


def run_command(manifest: Manifest, options: str) -> str:
    """The `dubins-study run` command that asks a folder's questions of other solvers.

    The folder's own command names its experiment's file, or its file of scenarios, which the
    experiment's name does not; the name stands where there is no such command. The `options` are
    appended as a shell reads them.
    """
    words = _asked_words(manifest.command) or [manifest.experiment.name]
    return f"dubins-study run {shlex.join(words)} {options}"


def _asked_words(command: str) -> list[str]:
    """The words of a run's command that say what it asks; none of a text that is no such command.

    >>> _asked_words("dubins-study run --scenarios 'my s.csv' --solver ipopt --jobs 2 --repeats 3")
    ['--scenarios', 'my s.csv', '--repeats', '3']
    """
    try:
        words = shlex.split(command)
    except ValueError:  # a quotation without an end
        return []
    if words[:2] != ["dubins-study", "run"]:
        return []
    before = ["", *words]
    pairs = zip(words[2:], before[2:], strict=False)
    return [word for word, last in pairs if not {word, last} & set(_OF_ANSWERS)]
