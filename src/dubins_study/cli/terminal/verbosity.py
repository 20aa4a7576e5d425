"""How much a command says on stderr besides refusals and warnings."""

from __future__ import annotations

import logging
from enum import IntEnum


class Verbosity(IntEnum):
    """Quiet: no progress. Normal: progress. Verbose: progress and the log of every step."""

    QUIET = -1
    NORMAL = 0
    VERBOSE = 1


_level = Verbosity.NORMAL
_LOG = logging.getLogger("dubins_study")


def verbosity() -> Verbosity:
    """The verbosity of the command that runs."""
    return _level


def set_verbosity(level: Verbosity) -> None:
    """Set the verbosity; a verbose command writes this package's log to stderr."""
    global _level
    _level = level
    for handler in [h for h in _LOG.handlers if isinstance(h, _StderrHandler)]:
        _LOG.removeHandler(handler)
    verbose = level == Verbosity.VERBOSE
    _LOG.setLevel(logging.INFO if verbose else logging.NOTSET)
    _LOG.propagate = not verbose
    if verbose:
        _LOG.addHandler(_StderrHandler())


class _StderrHandler(logging.StreamHandler):  # type: ignore[type-arg]
    """Writes records to stderr, with visible control characters."""

    def format(self, record: logging.LogRecord) -> str:
        from dubins_study.study.values import plain

        text = plain(super().format(record))
        return text if text.startswith("dubins-study:") else f"dubins-study: {text}"
