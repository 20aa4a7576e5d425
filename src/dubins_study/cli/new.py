"""`dubins-study new`: files to begin with."""

from __future__ import annotations

import keyword
import re
import shlex
from importlib.resources import files
from pathlib import Path as FilePath
from typing import Annotated

import typer

from dubins_study.cli.arguments import CommandError
from dubins_study.cli.terminal.command_line import CommandLine
from dubins_study.study.printable import plain

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
    if file.suffix != suffix:
        near = file.with_suffix(suffix).name if file.suffix else f"{file.name}{suffix}"
        raise CommandError(f"{file}: expected a name ending in {suffix}; did you mean {near}?")
    if not re.fullmatch(r"[A-Za-z]\w*", file.stem, re.ASCII) or keyword.iskeyword(file.stem):
        near = re.sub(r"\W+", "_", file.stem, flags=re.ASCII).strip("_0123456789") or "my"
        near = f"{near}_solver" if keyword.iskeyword(near) else near
        raise CommandError(
            f"{file}: expected a name of letters, digits and underscores, such as {example}; "
            f"did you mean {near}{suffix}?"
        )
    return file


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
