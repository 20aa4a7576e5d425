"""What a user waits for at the command line."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

from benchmarks.harness import Measurement, absent, side_by_side

HELP_S = 0.3


def measure() -> Iterable[Measurement]:
    command = Path(sys.executable).with_name("dubins-study")
    if not command.exists():
        yield absent("dubins-study --help", "the package is not installed here")
        return

    def call(*arguments: str) -> None:
        subprocess.run(arguments, stdout=subprocess.DEVNULL, check=True)

    times = side_by_side(
        {
            "help": lambda: call(str(command), "--help"),
            "python": lambda: call(sys.executable, "-c", "pass"),
        },
        repeats=9,
    )
    yield Measurement(
        "dubins-study --help, beside an empty Python",
        ours=times["help"].median,
        peer=times["python"].median,
        unit="s",
        ratio=times["help"].median,
        target=HELP_S,
        note="target in seconds",
    )
