"""The documentation: it builds without a warning, and its pages ask nothing of another host."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
# An attribute that makes a browser load something from another host. A link is not one.
LOADED = re.compile(
    r"<(?:img|script|iframe|source)[^>]+src=\"(?:https?:)?//[^\"]*\"|@import|url\(.?http"
)


@pytest.fixture(scope="session")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, built with every warning as an error; its notebooks are run."""
    out = tmp_path_factory.mktemp("docs") / "site"
    trees = str(out.with_name("trees"))
    options = ["-q", "-W", "--keep-going", "-d", trees]
    command = [sys.executable, "-m", "sphinx", *options, str(DOCS), str(out)]
    build = subprocess.run(command, capture_output=True, text=True, timeout=280)

    assert build.returncode == 0, build.stderr
    return out


@pytest.mark.slow
def test_the_site_builds_without_a_warning(site):
    """Every page is written: an unknown link, directive or reference is an error."""
    sources = {file.relative_to(DOCS).with_suffix("") for file in DOCS.rglob("*.md")}

    assert sources
    assert all((site / source.with_suffix(".html")).exists() for source in sources)


@pytest.mark.slow
def test_no_page_loads_anything_from_another_host(site):
    """The site works offline: fonts, scripts, pictures and formulas are in the folder."""
    for file in [*site.rglob("*.html"), *site.rglob("*.css")]:
        assert not LOADED.findall(file.read_text(encoding="utf-8")), file
