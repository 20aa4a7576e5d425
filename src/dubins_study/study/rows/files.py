"""Errors of a results folder."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

from dubins_study.errors import DubinsStudyError


class ResultsError(DubinsStudyError, ValueError):
    """A results folder that cannot be read or written; the message says which one and why."""


class DamagedPartError(ResultsError):
    """A part that was cut off or changed after it was written."""


def reason(error: OSError) -> str:
    """What went wrong, in the words of the system or of the library that raised the error."""
    if error.errno is not None:
        return os.strerror(error.errno)
    return error.strerror or str(error).partition("\n")[0] or type(error).__name__


@contextmanager
def os_errors_as(problem: str) -> Iterator[None]:
    """Raise an error of the operating system as a `ResultsError`: the problem and its reason."""
    try:
        yield
    except OSError as error:
        raise ResultsError(f"{problem}: {reason(error)}") from None
