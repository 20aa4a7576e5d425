"""Commands and code of the documentation work.

Every one does what the page says.

    console    lines that begin with `$ ` are commands; what follows is their output, in which `...`
               stands for anything
    sh         commands, of which the last exit code counts
    python     run in the namespace of its page
    pycon      a dialogue with `>>>`, its outputs compared as above
A block with a caption, or whose first line is a comment with a file's name, is written to that
file. Blocks of other languages must look like no command.
"""

import doctest
import os
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import pytest

RUN = ("console", "sh", "python", "pycon")
SHOWN = ("text", "toml", "json", "bibtex", "css", "yaml")
_FENCE = re.compile(r"^( *)(`{3,})([^\n`]*)\n(.*?)^\1\2 *$", re.M | re.S)
_FILE = re.compile(r"(?:#|//) ([\w.-]+\.\w+)\n")
_CAPTION = re.compile(r"(?:^:caption: *(\S+)\n|^:\w+:.*\n)+\n?", re.M)
_COMMAND = re.compile(r"^(?:\$ |make |pip |dubins-study |python )", re.M)
_MATCHES = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
# Seconds; far above what any command of the documentation takes.
_LIMIT_S = 200


class Block(NamedTuple):
    """A block of a page.

    It has its language, its text, the file that it is, and the line where it begins.
    """

    language: str
    text: str
    file: str
    line: int


def blocks(page: Path) -> list[Block]:
    """All blocks of a page in their order.

    Those of directives are left out.
    """
    entries = []
    source = page.read_text(encoding="utf-8")
    for match in _FENCE.finditer(source):
        indent, _, info, text = match.groups()
        text = re.sub(f"^{indent}", "", text, flags=re.M)
        language = info.strip()
        file = ""
        if language.startswith("{code-block}"):
            language = language.split()[-1]
            options = _CAPTION.match(text)
            if options:
                file = options[1] or ""
                text = text[options.end() :]
        if language.startswith("{"):
            continue
        named = _FILE.match(text)
        file = file or (named[1] if named else "")
        entries.append(Block(language, text, file, source.count("\n", 0, match.start()) + 2))
    return entries


def unknown(block: Block) -> bool:
    """Whether nobody would notice that a block fails."""
    if block.language in RUN or block.file:
        return False
    return block.language not in SHOWN or bool(_COMMAND.search(block.text))


class Runner:
    """Runner of a page's blocks.

    They run in their order, all in one folder that has the examples.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        (folder / "examples").symlink_to(ROOT / "examples")
        # a module of its own, in which a dataclass finds itself
        module = sys.modules["page_of_the_documentation"] = ModuleType("page_of_the_documentation")
        self.names: dict[str, Any] = vars(module)
        programs = Path(sys.executable).parent
        self.environment = os.environ | {
            "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}",
            "COLUMNS": "100",
            "NO_COLOR": "1",
        }

    def run(self, block: Block) -> None:
        """Run or write one block.

        An error has the command, its output and what the page says.
        """
        if block.file:
            (self.folder / block.file).write_text(block.text, encoding="utf-8")
        if block.file or block.language in SHOWN:
            return
        getattr(self, f"_{block.language}")(block)

    def _python(self, block: Block) -> None:
        # the line numbers of a traceback are those of the page
        code = compile("\n" * (block.line - 1) + block.text, "page", "exec")
        exec(code, self.names)

    def _pycon(self, block: Block) -> None:
        test = doctest.DocTestParser().get_doctest(block.text, self.names, "page", None, block.line)
        report: list[str] = []
        result = doctest.DocTestRunner(optionflags=_MATCHES).run(
            test, out=report.append, clear_globs=False
        )
        self.names |= test.globs
        assert not result.failed, "".join(report)

    def _sh(self, block: Block) -> None:
        self._command(block.text)

    def _console(self, block: Block) -> None:
        command = ""
        expected = ""
        for line in [*block.text.splitlines(keepends=True), "$ "]:
            if not line.startswith("$ "):
                expected += line
                continue
            if command:
                self._compare(command, expected)
            command = line[2:]
            expected = ""

    def _compare(self, command: str, expected: str) -> None:
        output = self._command(command)
        wanted = re.sub(r"\n\.\.\.\n\Z", "...", expected)  # of nothing as well
        same = doctest.OutputChecker().check_output(wanted, output, _MATCHES)
        assert same, f"$ {command}\nthe page says:\n{expected}\nit printed:\n{output}"

    def _command(self, command: str) -> str:
        """Standard output of a command.

        A command may fail if the page says so.
        """
        script = f"set -eo pipefail\n{command}"
        process = subprocess.run(
            ["bash", "-c", script],
            cwd=self.folder,
            env=self.environment,
            capture_output=True,
            text=True,
            timeout=_LIMIT_S,
        )
        output = f"{process.stdout}\n{process.stderr}"
        stated = re.search(r"# exit code (\d+)\s*$", command)
        allowed = int(stated[1]) if stated else 0
        assert process.returncode == allowed, f"$ {command}\nexit {process.returncode}\n{output}"
        return process.stdout


def parsed(block: Block) -> bool:
    """Whether a block has the form of code.

    That is Python, or commands of a shell.
    """
    if block.language == "python":
        compile(block.text, "page", "exec")
        return True
    lines = block.text.splitlines()
    if block.language == "console":
        lines = [line[2:] for line in lines if line.startswith("$ ")]
    shell = subprocess.run(["bash", "-n"], input="\n".join(lines), text=True, capture_output=True)
    return shell.returncode == 0


ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = {
    str(page.relative_to(ROOT)): blocks(page)
    for page in (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md")))
}
# Page and the beginning of a block that is parsed, but not run -> why.
NOT_RUN = {
    ("README.md", "make study"): "installs an environment; .ci/run begins with make",
    ("docs/reference-set.md", "dubins-study report"): "tests/unit/report/test_load.py has a folder",
    ("docs/reference-set.md", "g++"): "test_reference_set.py compiles it and asks a small suite",
    ("docs/reference-set.md", "dubins-study solve"): "programs that test_executables.py replaces",
    ("docs/submit.md", "dubins-study run"): "two suites take an hour; of a solver of the reader's",
    ("docs/submit.md", "dubins-study report"): "tests/unit/report/test_load.py has a folder",
    ("docs/plugins.md", "from dubins_study import load_results"): "reads the committed rows",
    (
        "docs/plugins.md",
        "dubins-study run benchmark-route",
    ): "tests/unit/experiments/test_scenario_file.py plans a sample of this suite",
    ("docs/tutorial.md", "pip install ."): "installs; tests/processes/test_wheel.py does the same",
    (
        "docs/flights.md",
        "pip install --no-deps",
    ): "installs; tests/processes/test_planner_packages.py tries the list",
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
SLOW = (
    *("docs/tutorial.md", "docs/survey.md", "docs/plugins.md", "docs/running.md"),
    *("docs/reference/api.md", "docs/recipes.md", "docs/tours.md", "README.md"),
    "docs/reference-set.md",
)


def reason(page: str, block: Block) -> str | None:
    """Why a block is not run, or None."""
    for (named, beginning), why in NOT_RUN.items():
        if named == page and block.text.startswith((beginning, f"$ {beginning}")):
            return why
    return None


def run_pages() -> list[object]:
    """Pages with something to run.

    The slow ones are marked.
    """
    pages = [page for page, parts in PAGES.items() if any(b.language in RUN for b in parts)]
    return [pytest.param(p, marks=[pytest.mark.slow] if p in SLOW else []) for p in pages]


@pytest.mark.many(2)
@pytest.mark.parametrize("page", run_pages())
def test_what_a_page_shows_runs(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """A page's blocks run.

    They run one by one in one new folder; outputs are compared where the page shows them.
    """
    monkeypatch.chdir(tmp_path)
    runner = Runner(tmp_path)
    for block in PAGES[page]:
        if reason(page, block) is None:
            runner.run(block)


@pytest.mark.smoke
@pytest.mark.parametrize(("page", "beginning"), NOT_RUN)
def test_a_block_that_is_not_run_exists_and_is_parsed(page: str, beginning: str):
    """Blocks that are not run exist and parse.

    A reason for a block that has gone is stale; the others are at least of the right form.
    """
    chosen = [
        b for b in PAGES[page] if reason(page, b) and b.text.lstrip("$ ").startswith(beginning)
    ]

    assert chosen
    assert all(parsed(block) for block in chosen)


@pytest.mark.smoke
def test_no_block_is_in_a_language_that_nobody_runs():
    """Every block's language is run or exempt.

    A command in a block of no language, or of text, would never be tried.
    """
    strange = [f"{page}:{b.line}" for page, parts in PAGES.items() for b in parts if unknown(b)]

    assert not strange


@pytest.mark.smoke
def test_a_wrong_page_fails(tmp_path: Path):
    """A wrong page fails.

    The runner itself sees a command that fails, or prints something else.
    """
    runner = Runner(tmp_path)
    runner.run(Block("console", "$ echo one; echo 2.5 s\none\n... s\n", "", 1))
    with pytest.raises(AssertionError, match=r"it printed:\s+two"):
        runner.run(Block("console", "$ echo two\none\n", "", 1))
    with pytest.raises(AssertionError, match="exit 3"):
        runner.run(Block("sh", "exit 3\n", "", 1))
    with pytest.raises(ZeroDivisionError):
        runner.run(Block("python", "1 / 0\n", "", 1))
    with pytest.raises(AssertionError, match="Expected"):
        runner.run(Block("pycon", ">>> 1 + 1\n3\n", "", 1))
