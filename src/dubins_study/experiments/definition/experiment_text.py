"""The files of experiments: those of the package and any other, read but not checked."""

from __future__ import annotations

import re
import tomllib
from importlib.resources import files
from pathlib import Path as FilePath
from typing import Any, NamedTuple

from dubins_study.errors import DubinsStudyError
from dubins_study.study.values import did_you_mean

# Python reads half a megabyte of TOML in a tenth of a second.
_MOST_BYTES = 2**20
# For a key of thousands of parts it takes a minute.
_MOST_PARTS = 50
_LONG_KEY = re.compile(rf"""(?:\.\s*(?:[\w-]+|"[^"\n]*"|'[^'\n]*')\s*){{{_MOST_PARTS}}}""")


class ExperimentError(DubinsStudyError, ValueError):
    """The experiment does not exist or is not valid; the message names file, key and value."""


def packaged() -> list[str]:
    """The names of the experiments that come with the package, sorted."""
    return sorted(_packaged_files())


def _packaged_files() -> dict[str, Any]:
    """The TOML files of the package by the experiment's name."""
    folder = files("dubins_study.experiments")
    return {
        file.name.removesuffix(".toml"): file
        for file in folder.iterdir()
        if file.name.endswith(".toml")
    }


class ExperimentText(NamedTuple):
    """The text of an experiment's file; `name` and `path` as in `ExperimentFile`."""

    name: str
    path: str
    text: str

    def fields(self) -> dict[str, Any]:
        """The keys of the file and their values.

        Raises:
            ExperimentError: if it is not TOML; the reader stops at the first mistake.
        """
        if long := _LONG_KEY.search(self.text):
            line = self.text.count("\n", 0, long.start()) + 1
            raise ExperimentError(
                f"{self.path}: line {line}: a key of more than {_MOST_PARTS} parts; expected fewer"
            )
        try:
            return tomllib.loads(self.text)
        except (ValueError, RecursionError) as error:  # also: a number too long, or deep nesting
            raise ExperimentError(
                f"{self.path}: not TOML: {error}; mend this first: nothing behind it can be read"
            ) from None


def text_of(name: str) -> ExperimentText:
    """The file of a packaged experiment by its name, or any by the path of its TOML file.

    Raises:
        ExperimentError: naming the file and why it cannot be read.
    """
    packaged_file = _packaged_files().get(name)
    if packaged_file is not None:
        return ExperimentText(name, packaged_file.name, packaged_file.read_text(encoding="utf-8"))
    path = FilePath(name)
    # The results folder is named after the stem; "." and ".." cannot name a new folder.
    if path.suffix != ".toml" or path.stem in (".", ".."):
        raise ExperimentError(
            f"no experiment named {name!r}; {did_you_mean(name, packaged())}choose one of: "
            f"{', '.join(packaged())}, or give the path of a .toml file"
        )
    try:
        if (size := path.stat().st_size) > _MOST_BYTES:
            raise ExperimentError(
                f"experiment {name}: {size} bytes; expected at most {_MOST_BYTES}: list scenarios "
                "in a .csv or .parquet file (--scenarios)"
            )
        return ExperimentText(path.stem, name, path.read_text(encoding="utf-8-sig"))
    except ExperimentError:
        raise
    except UnicodeError:
        raise ExperimentError(f"experiment {name}: cannot be read: it is not UTF-8 text") from None
    except OSError as error:
        raise ExperimentError(f"experiment {name}: cannot be read: {error.strerror}") from None
    except ValueError as error:  # a path that no file system takes, such as one with a NUL
        raise ExperimentError(f"experiment {name}: cannot be read: {error}") from None
