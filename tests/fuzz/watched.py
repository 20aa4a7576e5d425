"""What the interpreter says that it does: files written, programs started, code loaded."""

from __future__ import annotations

import contextlib
import functools
import gc
import io
import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

_STARTS = {"subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.spawn", "os.fork"}
# which arguments name places, and which the open folders that these may be relative to
_CHANGES = {
    "os.mkdir": ((0,), (2,)),
    "os.rename": ((0, 1), (2, 3)),
    "os.remove": ((0,), (1,)),
    "os.rmdir": ((0,), (1,)),
    "os.link": ((1,), (2, 3)),
    "os.symlink": ((1,), (2,)),
    "os.truncate": ((0,), ()),
    "os.chmod": ((0,), (2,)),
    "shutil.rmtree": ((0,), (1,)),
}
_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
_watchers: list[Callable[[str, tuple[Any, ...]], None]] = []


def _heard(event: str, arguments: tuple[Any, ...]) -> None:
    for watcher in _watchers:
        watcher(event, arguments)


sys.addaudithook(_heard)  # for good: there is no taking it back, but nobody listens outside tests


class Seen(NamedTuple):
    """What happened: programs started, names unpickled, places changed."""

    started: list[str]
    unpickled: list[str]
    changed: list[str]

    def outside(self, *folders: Path) -> list[str]:
        """The places that lie in none of the folders, links followed up to the last step.

        Byte code counts for nothing, which is kept of a module that is loaded for the first time.
        """
        allowed = [os.path.realpath(folder) for folder in folders]
        return [
            place
            for place in self.changed
            if "__pycache__" not in Path(place).parts
            and not any(_lands(place) == a or _lands(place).startswith(a + os.sep) for a in allowed)
        ]


def _lands(place: str) -> str:
    return str(Path(place).parent.resolve() / Path(place).name)


@contextlib.contextmanager
def watched() -> Iterator[Seen]:
    """Listen to the interpreter's own audit events."""
    seen = Seen([], [], [])

    def watcher(event: str, arguments: tuple[Any, ...]) -> None:
        if event in _STARTS:
            seen.started.append(f"{event} {arguments[:2]!r:.200}")
        elif event == "pickle.find_class":
            seen.unpickled.append(str(arguments))
        elif event == "open" and (arguments[2] or 0) & _WRITING:
            if isinstance(arguments[0], str | bytes):
                seen.changed.append(os.fsdecode(arguments[0]))
        elif event in _CHANGES:
            named, folders = _CHANGES[event]
            if any(arguments[i] not in (None, -1) for i in folders):
                return  # `shutil.rmtree` at work, which was told of itself
            places = (arguments[i] for i in named)
            seen.changed.extend(os.fsdecode(p) for p in places if isinstance(p, str | bytes | Path))

    _watchers.append(watcher)
    try:
        yield seen
    finally:
        _watchers.remove(watcher)


@functools.cache
def _freeze_modules() -> None:
    """Leave what is loaded by now out of collections: each would look through all libraries."""
    gc.collect()
    gc.freeze()


@contextlib.contextmanager
def temporary_files_in(folder: Path) -> Iterator[None]:
    """Let temporary files lie in a folder, and see to it that none is left."""
    _freeze_modules()
    scratch = folder / "temporary files"
    scratch.mkdir()
    with mock.patch.object(tempfile, "tempdir", str(scratch)):
        yield
        gc.collect()  # a database removes its files as it goes
    scratch.rmdir()


class Said(NamedTuple):
    """How a command ended, and what it printed."""

    code: int
    out: str
    err: str


def command(*arguments: str) -> Said:
    """`dubins-study` in this process, its streams as strict as a terminal's."""
    from dubins_study.cli.app import main

    kept, streams = (sys.argv, sys.stdout, sys.stderr), (io.BytesIO(), io.BytesIO())
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
        sys.argv, sys.stdout, sys.stderr = kept
    out, err = (stream.getvalue().decode("utf-8") for stream in streams)
    return Said(0 if code is None else code, out, err)


def raw_controls(text: str) -> set[str]:
    """Control characters in what was printed, line ends left out: a terminal would obey them."""
    return {c for c in text if (ord(c) < 32 and c not in "\n\t") or 127 <= ord(c) < 160}
