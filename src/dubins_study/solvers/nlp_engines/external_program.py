"""A program that is started in a folder, and ended with all that it started."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path as FilePath


def exit_code(
    command: Sequence[str | FilePath],
    folder: FilePath,
    seconds: float,
    environment: Mapping[str, str] | None = None,
) -> int | None:
    """The exit code of a program that reads and prints nothing; None if its time was up.

    It works in the folder, with this process's environment by default. When its time is up it is
    killed, and its children too.
    """
    process = subprocess.Popen(
        command,
        cwd=folder,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,  # so that its children can be ended with it
    )
    try:
        return process.wait(max(seconds, 0.0))
    except subprocess.TimeoutExpired:
        return None
    finally:
        with suppress(ProcessLookupError):  # it and its children may have ended already
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
