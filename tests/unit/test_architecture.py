"""docs/architecture.md names files and functions: all of them exist."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "src" / "dubins_study"
TEXT = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
# `room/`, `room/module.py` or `room/module.py:name`
NAMED = re.findall(r"`([\w/<>.-]+/|[\w/<>.-]+\.(?:py|toml))(?::(\w+))?`", TEXT)


def places(name: str) -> list[Path]:
    """What a name of the document stands for: one file or folder."""
    if name == "__init__.py":  # of every room
        return list(PACKAGE.glob("*/__init__.py"))
    root = ROOT if name in ("src/dubins_study/", "pyproject.toml") else PACKAGE
    return list(root.glob(name.rstrip("/")))


def defined(file: Path) -> set[str]:
    """The names that a module defines at its top level."""
    names: set[str] = set()
    for node in ast.parse(file.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.add(node.name)
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names |= {target.id for target in targets if isinstance(target, ast.Name)}
    return names


@pytest.mark.parametrize(("file", "name"), sorted(set(NAMED)))
def test_what_the_document_names_exists(file, name):
    """A reader who follows the document arrives."""
    assert places(file), f"docs/architecture.md names {file}, which does not exist"
    if name:
        assert name in defined(places(file)[0]), f"{file} does not define {name}"


def test_the_document_answers_its_thirteen_questions():
    """Each question has a row that names at least one file."""
    rows = re.findall(r"^\| (wh[^|]*\?) \|(.*)\|$", TEXT, re.M)

    assert len(rows) == 13
    assert all("`" in answer for _, answer in rows)
    assert len(NAMED) > 30
