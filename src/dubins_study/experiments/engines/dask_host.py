"""A Dask cluster of this machine alone, in a process of its own.

Dask's LocalCluster changes the environment of the process that it is made in, imports its main
module once more in every worker, lets Ctrl-C end its workers and prints what goes wrong. Here it
has a process for itself, in a session of its own, which ends when whoever started it does.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import IO, NamedTuple

from dubins_study.experiments.isolation import process_tree
from dubins_study.experiments.isolation.pool import RunError

# s that a cluster is given to start (its workers load this project, on a busy machine too), and to
# end by itself
_START_UP, _PARTING = 120.0, 5.0
_OUTPUT_BYTES = 200
# the caller's search path, so that whatever is imported there is found; -P: nothing else is
_PROGRAM = (
    "import sys, json; sys.path[:] = json.loads(sys.stdin.readline()); "
    "from dubins_study.experiments.engines.dask_cluster import main; main()"
)


class Host(NamedTuple):
    """Where a cluster is: its scheduler's address, and the page that shows what it does."""

    address: str
    dashboard: str


@contextmanager
def local_cluster(workers: int) -> Iterator[Host]:
    """A scheduler and so many worker processes of one thread each, on the loopback only.

    Raises:
        RunError: if they do not start.
    """
    scratch_folder = tempfile.TemporaryDirectory(prefix="dubins-study-", ignore_cleanup_errors=True)
    with scratch_folder as scratch, tempfile.TemporaryFile() as errors:
        process = subprocess.Popen(
            [sys.executable, "-P", "-c", _PROGRAM],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=errors,
            text=True,
            start_new_session=True,
        )
        try:
            yield _told(process, workers, scratch, errors)
        finally:
            _end(process)


def _told(process: subprocess.Popen[str], workers: int, scratch: str, errors: IO[bytes]) -> Host:
    assert process.stdin is not None
    assert process.stdout is not None
    asked = json.dumps(sys.path) + "\n" + json.dumps([workers, scratch]) + "\n"
    with suppress(BrokenPipeError):  # it has ended; its last output says why
        process.stdin.write(asked)
        process.stdin.flush()
    patience = threading.Timer(_START_UP, process.kill)
    patience.start()
    said = process.stdout.readline()
    patience.cancel()
    if not said:
        process.wait(_PARTING)
        raise RunError(f"Dask's cluster on this machine did not start: {_end_of(errors)}")
    return Host(*json.loads(said))


def _end_of(errors: IO[bytes]) -> str:
    """The last that was printed, on one line."""
    errors.seek(max(0, errors.seek(0, os.SEEK_END) - _OUTPUT_BYTES))
    return " ".join(errors.read().decode("utf-8", "replace").split())


def _end(process: subprocess.Popen[str]) -> None:
    """Ask it to end by itself, so that it tidies up; what is left then is killed."""
    try:
        with suppress(OSError):
            assert process.stdin is not None
            process.stdin.close()
        with suppress(subprocess.TimeoutExpired):
            process.wait(_PARTING)
    finally:
        ending = process_tree.end if process.poll() is None else process_tree.end_session
        ending(process.pid)
        process.wait()
        assert process.stdout is not None
        process.stdout.close()
