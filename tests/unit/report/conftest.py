"""Fixtures of the report's tests."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path as FilePath
from typing import Any

import pytest
from matplotlib.figure import Figure

from dubins_study.report.elements.figure_file import figure_bytes
from tests.unit.report.results_folder import write_folder


@pytest.fixture
def results(tmp_path: FilePath) -> Callable[..., FilePath]:
    """Writes a results folder below the test's own."""

    def make(name: str, rows: Iterable[dict[str, Any]], **manifest: Any) -> FilePath:
        return write_folder(tmp_path / name, name, rows, **manifest)

    return make


@pytest.fixture(autouse=True, scope="module")
def svg_alone() -> Iterator[None]:
    """Figures as SVG alone: fonts are cut for every PDF anew, a third of what a page costs.

    A test that looks at PDF files draws them inside `with_pdf_files()`.
    """

    def drawn(figure: Figure, kind: str) -> bytes:
        return b"%PDF" if kind == "pdf" else figure_bytes(figure, kind)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("dubins_study.report.page.render.figure_bytes", drawn)
        yield
