"""CITATION.cff and the citation in the reports are the same, and neither invents anything."""

from __future__ import annotations

import tomllib
from pathlib import Path as FilePath

import pytest
import yaml

from dubins_study.report.paper.printed import CITATION, TITLE

ROOT = FilePath(__file__).parents[3]
# What the format's schema, version 1.2.0, requires of a file, and of a reference; and their values.
REQUIRED = {"cff-version", "message", "title", "authors"}
KNOWN = REQUIRED | {"type", "abstract", "version", "license", "keywords", "references"}
OF_A_REFERENCE = {"type", "title", "authors"}


@pytest.fixture(scope="module")
def citation():
    return yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))


def test_the_file_has_the_keys_of_its_format(citation):
    """All that are required, none that the format does not know, every author with a name."""
    assert set(citation) >= REQUIRED
    assert set(citation) <= KNOWN
    assert citation["cff-version"] == "1.2.0"
    assert citation["type"] in ("software", "dataset")
    assert all(set(author) == {"name"} for author in citation["authors"])
    for reference in citation["references"]:
        assert set(reference) >= OF_A_REFERENCE
        assert reference["authors"]


def test_the_file_agrees_with_the_package(citation):
    """Version, licence, authors and keywords are those of pyproject.toml."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]

    assert str(citation["version"]) == project["version"]
    assert citation["license"] == project["license"]
    assert citation["authors"] == project["authors"]
    assert set(citation["keywords"]) == set(project["keywords"])


def test_the_file_cites_the_paper_as_the_reports_do(citation):
    """One title; no authors and no year, as long as the reports know none."""
    (paper,) = citation["references"]

    assert paper["title"] == TITLE
    assert TITLE in CITATION
    assert "year" not in paper
    assert [author["name"] for author in paper["authors"]] == ["authors unknown to this study"]
