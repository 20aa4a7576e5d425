"""`dubins-study new`: files to begin with."""

from __future__ import annotations

import keyword
import re
import shlex
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path as FilePath
from typing import Annotated

import typer

from dubins_study.cli.terminal.arguments import CommandError
from dubins_study.cli.terminal.output import plain


def solver(
    file: Annotated[FilePath, typer.Argument(metavar="FILE", help="such as my_solver.py")],
) -> None:
    """Write a solver that works, with comments."""
    _check_name(file, r"[A-Za-z]\w*\.py", "my_solver.py")
    if keyword.iskeyword(file.stem) or (not file.exists() and find_spec(file.stem) is not None):
        raise CommandError(f"{file}: expected a name that hides no module, as my_solver.py")
    title = class_name(file.stem)
    name = file.stem.replace("_", "-")
    _write(file, "solver.py.txt", {"file": file.name, "Class": title, "name": name})
    print(f"{plain(str(file))} is written: the solver {title}")
    print(f"check it:  {shlex.join(['dubins-study', 'check-solver', f'{file}:{title}'])}")


def experiment(
    file: Annotated[FilePath, typer.Argument(metavar="FILE", help="such as my_experiment.toml")],
) -> None:
    """Write an experiment that runs, with comments."""
    _check_name(file, r"[A-Za-z0-9][\w.-]*\.toml", "my-experiment.toml")
    title = file.stem.replace("-", " ").replace("_", " ").capitalize()
    values = {"file": plain(str(file)), "name": file.stem, "title": title}
    _write(file, "experiment.toml.txt", values)
    print(f"{plain(str(file))} is written: an experiment that runs")
    print(f"what it asks:  {shlex.join(['dubins-study', 'experiments', str(file)])}")
    print(f"run it:        {shlex.join(['dubins-study', 'run', str(file)])}")


def class_name(stem: str) -> str:
    """The class of a file: MySolver for my_solver.py."""
    return "".join(part[:1].upper() + part[1:] for part in stem.split("_"))


def _check_name(file: FilePath, pattern: str, example: str) -> None:
    if not re.fullmatch(pattern, file.name, re.ASCII):
        raise CommandError(f"{file}: expected a name of plain characters, such as {example}")


def _write(file: FilePath, template: str, values: dict[str, str]) -> None:
    """Write a new file from a template.

    In the template, `{name}` stands for a value.
    """
    text = (files("dubins_study.cli") / "templates" / template).read_text(encoding="utf-8")
    for name, value in values.items():
        text = text.replace(f"{{{name}}}", value)
    try:
        with file.open("x", encoding="utf-8") as stream:
            stream.write(text)
    except FileExistsError:
        raise CommandError(f"{file} exists; expected the name of a new file") from None
    except OSError as error:
        raise CommandError(f"cannot write {file}: {error.strerror}") from None
