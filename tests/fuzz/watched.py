"""A command in this process, and what it leaves.

Its output and its temporary files are watched.
"""

import contextlib
import functools
import gc
import io
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock


@functools.cache
def _freeze_modules() -> None:
    """Keep all loaded objects out of collections.

    Each collection would look through all libraries.
    """
    gc.collect()
    gc.freeze()


@contextlib.contextmanager
def temporary_files_in(folder: Path) -> Iterator[None]:
    """Put temporary files into a folder.

    None may be left at the end.
    """
    _freeze_modules()
    scratch = folder / "temporary files"
    scratch.mkdir()
    with mock.patch.object(tempfile, "tempdir", str(scratch)):
        yield
        gc.collect()  # a database removes its files as it goes
    scratch.rmdir()


class CommandResult(NamedTuple):
    """How a command ended, and what it printed."""

    code: int
    out: str
    err: str


def command(*arguments: str) -> CommandResult:
    """Run `dubins-study` in this process.

    Its streams are as strict as a terminal's.
    """
    from dubins_study.cli.app import main

    original = (sys.argv, sys.stdout, sys.stderr)
    streams = (io.BytesIO(), io.BytesIO())
    sys.argv = ["dubins-study", *arguments]
    errors = ("strict", "backslashreplace")
    wrapped = [
        io.TextIOWrapper(stream, "utf-8", errors=how, write_through=True)
        for stream, how in zip(streams, errors, strict=True)
    ]
    sys.stdout, sys.stderr = wrapped
    try:
        main()
        code: Any = 0
    except SystemExit as end:
        code = end.code
    finally:
        sys.argv, sys.stdout, sys.stderr = original
    out, err = (stream.getvalue().decode("utf-8") for stream in streams)
    if code is None:
        code = 0
    return CommandResult(code, out, err)


def raw_controls(text: str) -> set[str]:
    """Control characters in a text, without line ends.

    A terminal would obey them.
    """
    return {c for c in text if (ord(c) < 32 and c not in "\n\t") or 127 <= ord(c) < 160}
