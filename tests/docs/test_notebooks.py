"""The notebooks of `examples/notebooks`; the build of the site runs them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
NOTEBOOKS = sorted((ROOT / "examples" / "notebooks").glob("*.ipynb"))


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda file: file.stem)
def test_a_notebook_is_stored_without_outputs(notebook: Path):
    """Outputs would be of some machine and some day; the site shows those of its build."""
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    code = [cell for cell in cells if cell["cell_type"] == "code"]

    assert code
    assert all(not cell["outputs"] and cell["execution_count"] is None for cell in code)
    assert all(not cell["metadata"] for cell in cells)


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda file: file.stem)
def test_a_notebook_fails_where_its_statements_are_wrong(notebook: Path):
    """Each checks what its text says, so that the build notices when it is no longer so."""
    assert "assert " in notebook.read_text(encoding="utf-8")


def test_both_notebooks_are_pages():
    """They lie in the tree of the site, by a link, and are named in its contents."""
    page = (ROOT / "docs" / "notebooks.md").read_text(encoding="utf-8")

    assert len(NOTEBOOKS) == 2
    assert all(f"notebooks/{notebook.stem}" in page for notebook in NOTEBOOKS)
    assert (ROOT / "docs" / "notebooks").resolve() == NOTEBOOKS[0].parent
