"""`dubins-study new`: files to begin with."""

from __future__ import annotations

import keyword
import re
import shlex
import sys
from importlib.machinery import PathFinder
from importlib.resources import files
from pathlib import Path as FilePath
from typing import Annotated

import typer

from dubins_study.cli.terminal.command_line import CommandLine
from dubins_study.cli.terminal.refusals import CommandError
from dubins_study.study.values import plain

app = CommandLine("new", "Write a file to begin with.")


@app.callback()
def _new() -> None:
    """Write a file to begin with."""


@app.command()
def solver(
    file: Annotated[FilePath, typer.Argument(metavar="FILE", help="such as my_solver.py")],
) -> None:
    """Write a solver that works, with comments."""
    target = checked_target(file, ".py", "my_solver.py")
    title = class_name(target.stem)
    text = template("solver.py.txt")
    values = {"file": target.name, "Class": title, "name": target.stem.replace("_", "-")}
    for name, value in values.items():
        text = text.replace(f"{{{name}}}", value)
    write_new(target, text)
    print(f"{plain(str(file))} is written: the solver {title}")
    print(f"check it:  {shlex.join(['dubins-study', 'check-solver', f'{file}:{title}'])}")


@app.command()
def experiment(
    file: Annotated[FilePath, typer.Argument(metavar="FILE", help="such as my_experiment.toml")],
) -> None:
    """Write an experiment that runs, with comments."""
    if file.suffix != ".toml" or not re.fullmatch(r"[A-Za-z0-9][\w.-]*", file.stem, re.ASCII):
        near = re.sub(r"[^A-Za-z0-9_-]+", "-", file.stem).strip("-_") or "my-experiment"
        raise CommandError(
            f"{file}: expected a name of letters, digits and hyphens that ends in .toml; "
            f"did you mean {near}.toml?"
        )
    text = template("experiment.toml.txt")
    title = file.stem.replace("-", " ").replace("_", " ").capitalize()
    for name, value in {"file": plain(str(file)), "name": file.stem, "title": title}.items():
        text = text.replace(f"{{{name}}}", value)
    write_new(file, text)
    print(f"{plain(str(file))} is written: an experiment that runs")
    print(f"what it asks:  {shlex.join(['dubins-study', 'experiments', str(file)])}")
    print(f"run it:        {shlex.join(['dubins-study', 'run', str(file)])}")


def template(name: str) -> str:
    """The text of a template."""
    return (files("dubins_study.cli") / "templates" / name).read_text(encoding="utf-8")


def checked_target(file: FilePath, suffix: str, example: str) -> FilePath:
    """The file, if its name fits.

    Raises:
        CommandError: naming the file, what was expected and the nearest name that fits.
    """
    if file.exists():  # said before anything about its name
        raise CommandError(f"{file} exists; expected the name of a new file")
    near = f"{_importable(file.stem or 'my')}{suffix}"
    if file.suffix != suffix:
        raise CommandError(f"{file}: expected a name ending in {suffix}; did you mean {near}?")
    if file.name == near:
        return file
    if file.stem.isidentifier() and _is_installed(file.stem):
        raise CommandError(
            f"{file}: expected a name that hides no module; Python would import this file instead "
            f"of the installed {file.stem}. Did you mean {near}?"
        )
    raise CommandError(
        f"{file}: expected a name of letters, digits and underscores, such as {example}; "
        f"did you mean {near}?"
    )


def _importable(stem: str) -> str:
    """The name nearest to a stem that a module may have and that hides no other module."""
    name = stem
    if not re.fullmatch(r"[A-Za-z]\w*", stem, re.ASCII):
        name = re.sub(r"\W+", "_", stem, flags=re.ASCII).strip("_0123456789") or "my_solver"
    while keyword.iskeyword(name) or _is_installed(name):
        name += "_solver"
    return name


def _is_installed(name: str) -> bool:
    """Whether Python has a module of a name, elsewhere than in the working directory."""
    if name in sys.stdlib_module_names:
        return True
    here = {"", str(FilePath.cwd())}
    return (
        PathFinder.find_spec(name, [place for place in sys.path if place not in here]) is not None
    )


def class_name(stem: str) -> str:
    """The name of the class in a file, e.g. MySolver in my_solver.py."""
    return "".join(part[:1].upper() + part[1:] for part in stem.split("_"))


def write_new(file: FilePath, text: str) -> None:
    """Write a file that does not exist yet.

    Raises:
        CommandError: if it exists, or cannot be written.
    """
    try:
        with file.open("x", encoding="utf-8") as stream:
            stream.write(text)
    except FileExistsError:
        raise CommandError(f"{file} exists; expected the name of a new file") from None
    except OSError as error:
        raise CommandError(f"cannot write {file}: {error.strerror}") from None
