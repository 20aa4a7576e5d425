"""Fixtures of the report's tests."""

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path as FilePath
from typing import Any

import pytest

from dubins_study.report.data.results import Results, load
from tests.unit.report.results_folder import write_folder
from tests.unit.report.topic_page import without_pdf_files


@pytest.fixture
def results(tmp_path: FilePath) -> Callable[..., FilePath]:
    """Writes a results folder below the test's own."""

    def make(name: str, rows: Iterable[dict[str, Any]], **manifest: Any) -> FilePath:
        return write_folder(tmp_path / name, name, rows, **manifest)

    return make


@pytest.fixture
def load_rows(results: Callable[..., FilePath]) -> Callable[..., Results]:
    """Write a results folder and load it.

    It lies below the test's own folder.
    """
    return lambda *given, **manifest: load([results(*given, **manifest)])


@pytest.fixture(autouse=True, scope="module")
def svg_alone() -> Iterator[None]:
    """Leave PDF files out.

    A test that looks at PDF files draws them inside `with_pdf_files()`.
    """
    with without_pdf_files():
        yield
