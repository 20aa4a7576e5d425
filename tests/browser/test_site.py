"""The documentation's site builds and works.

It builds without a warning, and its pages work offline and on a phone.
"""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.browser_tab import PHONE

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
# An attribute that makes a browser load something from another host. A link is not one.
LOADED = re.compile(
    r"<(?:img|script|iframe|source|link)[^>]+(?:src|href)=\"(?:https?:)?//[^\"]*\"|url\(.?http"
)

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, with every warning an error.

    Its notebooks are run.
    """
    out = tmp_path_factory.mktemp("docs").resolve() / "site"
    options = ["-q", "-W", "--keep-going", "-d", str(out.with_name("trees"))]
    command = [sys.executable, "-m", "sphinx", *options, str(DOCS), str(out)]
    build = subprocess.run(command, capture_output=True, text=True, timeout=900)

    assert build.returncode == 0, build.stderr
    return out


def pages_of(site: Path) -> list[Path]:
    """The pages that have a source."""
    sources = [*DOCS.rglob("*.md"), *(ROOT / "examples" / "notebooks").glob("*.ipynb")]
    names = [f.relative_to(DOCS if DOCS in f.parents else ROOT / "examples") for f in sources]
    return [site / name.with_suffix(".html") for name in names]


def test_no_page_names_anything_of_another_host(site: Path):
    """Fonts, scripts, pictures and formulas lie in the folder."""
    for file in [*site.rglob("*.html"), *site.rglob("*.css")]:
        assert not LOADED.findall(file.read_text(encoding="utf-8")), file


def test_no_link_leads_nowhere(site: Path):
    """No link leads nowhere.

    Links go between pages, to places within them, and to files; Sphinx checks only its own.
    """
    texts = {page: page.read_text(encoding="utf-8") for page in site.rglob("*.html")}
    places = {page: set(re.findall(r'\bid="([^"]+)"', text)) for page, text in texts.items()}
    wrong = []
    for page, text in texts.items():
        for link in set(re.findall(r'(?:href|src)="(?!https?:|mailto:|data:)([^"]+)"', text)):
            name, _, place = link.partition("#")
            target = (page.parent / name.partition("?")[0]).resolve() if name else page
            known = target.exists() and (not place or place in places.get(target, {place}))
            wrong += [] if known else [f"{page.name}: {link}"]

    assert not wrong


def test_every_page_fits_a_phone(site: Path, new_tab):
    """Every page fits a phone.

    At 400 pixels there is no sideways scrolling, no error in the console, no request to a host.
    """
    tab = new_tab(viewport=PHONE, color_scheme="dark")
    for page in pages_of(site):
        tab.goto(page.as_uri())
        width = tab.evaluate("document.documentElement.scrollWidth")

        assert width <= PHONE["width"], f"{page.name} is {width} pixels wide"
