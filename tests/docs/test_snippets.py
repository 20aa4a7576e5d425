"""Every command and every piece of code that the documentation shows does what the page says."""

from __future__ import annotations

from pathlib import Path

import pytest
from snippets import RUN, Block, Runner, blocks, parsed, unknown

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = {
    str(page.relative_to(ROOT)): blocks(page)
    for page in (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md")))
}
# Page and the beginning of a block that is parsed, but not run -> why.
NOT_RUN = {
    ("README.md", "make study"): "installs an environment; .ci/run begins with make",
    ("docs/tutorial.md", "pip install ."): "installs; tests/processes/test_wheel.py does the same",
    ("docs/scaling.md", "dask ssh "): "needs several hosts",
    ("docs/scaling.md", "from distributed import SSHCluster"): "needs several hosts",
    ("docs/scaling.md", "from dask_jobqueue import"): "needs a SLURM cluster",
    ("docs/scaling.md", "helm install"): "needs a Kubernetes cluster",
    ("docs/scaling.md", "from dask_kubernetes"): "needs a Kubernetes cluster",
    (
        "docs/scaling.md",
        "openssl req",
    ): "its servers do not end; tests/processes/test_dask_network.py",
}
# Pages whose blocks take more than some five seconds in all; `--slow` runs them.
SLOW = ("docs/tutorial.md", "docs/plugins.md", "docs/running.md")


def reason(page: str, block: Block) -> str | None:
    """Why a block is not run, or None."""
    for (named, beginning), why in NOT_RUN.items():
        if named == page and block.text.startswith((beginning, f"$ {beginning}")):
            return why
    return None


def run_pages() -> list[object]:
    """The pages with something to run, the slow ones marked."""
    pages = [page for page, parts in PAGES.items() if any(b.language in RUN for b in parts)]
    return [pytest.param(p, marks=[pytest.mark.slow] if p in SLOW else []) for p in pages]


@pytest.mark.parametrize("page", run_pages())
def test_what_a_page_shows_runs(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Block by block in one new folder; outputs are compared where the page shows them."""
    monkeypatch.chdir(tmp_path)
    runner = Runner(tmp_path)
    for block in PAGES[page]:
        if reason(page, block) is None:
            runner.run(block)


@pytest.mark.parametrize(("page", "beginning"), NOT_RUN)
def test_a_block_that_is_not_run_exists_and_is_parsed(page: str, beginning: str):
    """A reason for a block that has gone is stale; the others are at least of the right form."""
    chosen = [
        b for b in PAGES[page] if reason(page, b) and b.text.lstrip("$ ").startswith(beginning)
    ]

    assert chosen
    assert all(parsed(block) for block in chosen)


def test_no_block_is_in_a_language_that_nobody_runs():
    """A command in a block of no language, or of text, would never be tried."""
    strange = [f"{page}:{b.line}" for page, parts in PAGES.items() for b in parts if unknown(b)]

    assert not strange


def test_a_wrong_page_fails(tmp_path: Path):
    """The runner itself: a command that fails, or prints something else, is seen."""
    runner = Runner(tmp_path)
    runner.run(Block("console", "$ echo one; echo 2.5 s\none\n... s\n", "", 1))
    with pytest.raises(AssertionError, match="it printed:\ntwo"):
        runner.run(Block("console", "$ echo two\none\n", "", 1))
    with pytest.raises(AssertionError, match="exit 3"):
        runner.run(Block("sh", "exit 3\n", "", 1))
    with pytest.raises(ZeroDivisionError):
        runner.run(Block("python", "1 / 0\n", "", 1))
    with pytest.raises(AssertionError, match="Expected"):
        runner.run(Block("pycon", ">>> 1 + 1\n3\n", "", 1))
