"""Generated documentation is complete and up to date.

The package generates it, or it names parts of the package.
"""

import inspect
import json
import pkgutil
import re
import tomllib
from collections.abc import Iterator
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from types import ModuleType

import pytest
from jsonschema import Draft202012Validator

import dubins_study
from dubins_study.experiments.definition.experiment import packaged
from dubins_study.report.page.glossary import GLOSSARY, WORDS
from dubins_study.report.page.sections import TOPICS
from dubins_study.report.topics.findings import FINDINGS
from dubins_study.solvers.convex.adapters import ENGINES as CONVEX
from dubins_study.solvers.engines import ENGINES, names
from dubins_study.solvers.registry import load, settings
from dubins_study.study.rows.manifest import read_manifest
from dubins_study.study.words import NLP, PROVEN, QP, ROOTS, Claim, Outcome, Proof, Verdict

DOCS = Path(__file__).parents[2] / "docs"
ROOT = DOCS.parent
PACKAGE = ROOT / "src" / "dubins_study"
FOLDER = files("dubins_study.experiments")
SCHEMA = FOLDER / "experiment.schema.json"
SUITES = (
    "convex",
    "route",
    "pose",
    "leg",
    "tour",
    "search",
    "proof",
)  # of which rows are committed


@pytest.mark.parametrize("name", packaged())
def test_every_packaged_experiment_is_valid_by_the_schema(name):
    """Every packaged experiment is valid by the schema.

    The schema is checked by another library than the one that reads experiments.
    """
    fields = tomllib.loads((FOLDER / f"{name}.toml").read_text(encoding="utf-8"))
    validator = Draft202012Validator(json.loads(SCHEMA.read_text(encoding="utf-8")))

    assert not list(validator.iter_errors(fields))
    assert list(validator.iter_errors(fields | {"solver": ["ipopt"]}))  # the key is `solvers`


@pytest.fixture
def generator(monkeypatch: pytest.MonkeyPatch):
    """A module of `docs/ext` by its name."""
    monkeypatch.syspath_prepend(str(DOCS / "ext"))

    def loaded(name: str) -> ModuleType:
        return import_module(name)

    return loaded


def test_the_schema_file_is_that_of_the_models(generator):
    """Write it anew with `python docs/ext/toml_reference.py`."""
    assert SCHEMA.read_text(encoding="utf-8") == generator("toml_reference").schema_text()


def test_every_setting_of_every_solver_has_a_meaning(generator):
    """Every setting of every solver has a meaning.

    The tables of settings are made of docstrings; a setting that none explains is missing.
    """
    tables = generator("package_tables")
    names = tables.solver_names()

    assert len(names) >= 13
    for name in names:
        unexplained = set(settings(load(name))) - set(tables.setting_meanings(type(load(name))))
        assert not unexplained, f"{name}: no docstring explains {unexplained}"


def test_every_command_has_its_section(generator):
    """`dubins-study --help` and the page name the same commands."""
    page = (DOCS / "reference" / "command-line.md").read_text(encoding="utf-8")

    shown = re.findall(r"^```{generated} command (.*)$", page, re.M)

    assert sorted(shown) == sorted(generator("command_line").commands())


def test_the_reference_has_the_public_names():
    """The reference has the public names.

    It has an entry for each, and for nothing else. After each function's entry an example of a
    call is run.
    """
    page = (DOCS / "reference" / "api.md").read_text(encoding="utf-8")
    kinds, names = zip(*re.findall(r"^\.\. auto(\w+):: (\S+)$", page, re.M), strict=True)
    after = re.split(r"^\.\. auto\w+:: \S+$", page, flags=re.M)[1:]

    assert sorted(names) == sorted(dubins_study.__all__)
    assert kinds.count("function") >= 10
    for kind, name, text in zip(kinds, names, after, strict=True):
        if kind == "function":
            [example] = re.findall(r"^```pycon\n(.*?)^```$", text, re.M | re.S)[:1]
            assert re.search(rf"^>>> .*\b{name}\(", example, re.M), name


def test_every_key_of_an_experiment_is_explained(generator):
    """Every key of an experiment is explained.

    A key without a docstring would be a row without a meaning.
    """
    schema = json.loads(SCHEMA.read_text(encoding="utf-8"))
    page = (DOCS / "reference" / "experiment.md").read_text(encoding="utf-8")
    shown = re.findall(r"^```{generated} toml (\w+)$", page, re.M)
    tables = {"Experiment": schema} | schema["$defs"]
    ways = {"Range", "Spaced"}  # told in words under *Axes*

    assert set(shown) == set(tables) - ways
    for name in set(shown) - {"Block"}:
        assert "| needed |" in generator("toml_reference").toml_table(name)


def test_every_section_of_the_report_is_explained():
    """Every section of the report is explained.

    The order is that of the page, and the names are those that progress shows.
    """
    page = (DOCS / "report.md").read_text(encoding="utf-8")
    table = page.partition("| section | what to read from it |\n|---|---|\n")[2].partition("\n\n")[
        0
    ]

    assert re.findall(r"^\| ([^|]*) \|", table, re.M) == [topic.title for topic in TOPICS]


GLOSSARY_HEAD = """# Glossary

The words of this project; each means one thing everywhere: in the code, in the rows, in the report.
"""


def glossary_page() -> str:
    """The documentation's page of the glossary.

    `report/page/glossary.py` declares its words.
    """
    parts = [GLOSSARY_HEAD]
    for title, words in GLOSSARY.items():
        parts.append(f"## {title}\n")
        parts += [
            f"{word.term}\n: {' '.join((word.meaning, word.more)).strip()}\n" for word in words
        ]
    return "\n".join(parts)


def test_the_glossary_is_the_page_s():
    """Write it anew with `python -m tests.docs.test_reference > docs/glossary.md`."""
    assert (DOCS / "glossary.md").read_text(encoding="utf-8") == glossary_page()


@pytest.mark.parametrize("words", [Outcome, Claim, Verdict, Proof])
def test_the_glossary_lists_what_may_be_said(words):
    [meaning] = [each.meaning for each in WORDS if each.term == words.__name__.lower()]

    assert {*re.findall(r"`(.+?)`", meaning)} == set(words)


def test_the_words_of_readme_are_the_glossary_s():
    """Some of them, in its order."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    table = readme.partition("| word | meaning |\n|---|---|\n")[2].partition("\n\n")[0]
    rows = [f"| {word.term} | {word.meaning} |" for word in WORDS]

    assert 5 < len(table.splitlines()) < 12
    assert table.splitlines() == [row for row in rows if row in table]


def test_every_sentence_of_the_findings_is_explained():
    """Every sentence of the findings is explained.

    They come in their order, by the word that begins the sentence.
    """
    page = (DOCS / "report.md").read_text(encoding="utf-8")
    table = page.partition("| sentence | what is compared |\n|---|---|\n")[2].partition("\n\n")[0]
    first_words = re.findall(r"^\| (\w+) ", table, re.M)

    assert len(first_words) == len(FINDINGS)
    for word, find in zip(first_words, FINDINGS, strict=True):
        assert re.search(rf"[\"']{word.capitalize()} ", inspect.getsource(find)), word


# `folder/file.py`, or with a name that it has: `folder/file.py:name`
FILE_NAME = re.compile(r"(?<![\w./*-])((?:[\w-]+/)+[\w-]+\.(?:py|js|md))\b(?::(\w+))?")
# `room.module`, `room.module.name` or `dubins_study.room.module.name`
DOTTED_NAME = re.compile(
    r"(?:`|dubins_study\.)((?:study|solvers|experiments|conformance|report)(?:\.\w+)+)"
)
ELSEWHERE = ("scipy/", "results/", "a/my_solver.py")  # of SciPy, of a run, of an example


def texts() -> Iterator[Path]:
    """Texts of the documentation and of the package.

    The package's scripts and templates belong to them.
    """
    yield from (ROOT / name for name in ("README.md", "CONTRIBUTING.md", "pyproject.toml"))
    for folder in (DOCS, PACKAGE):
        for file in folder.rglob("*"):
            if file.suffix in (".md", ".py", ".js", ".j2", ".toml", ".txt"):
                yield file


def test_contributing_lists_the_folders_of_tests_and_the_targets_of_make():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    folders = {file.parent.relative_to(ROOT).parts[1] for file in ROOT.glob("tests/*/**/test_*.py")}
    targets = set(re.findall(r"^([a-z-]+):.*##", makefile, re.M)) - {"help", "clean"}

    assert set(re.findall(r"^\| `tests/(\w+)/` \|", text, re.M)) == folders
    assert set(re.findall(r"`make ([a-z-]+)[ `]", text)) == targets


def test_files_and_names_that_a_text_names_exist():
    """Files and names that a text names exist.

    They are files and their contents, and modules of the package and their definitions.
    """
    folders = ("src", "tests", "docs", "benchmarks", "examples")
    known = [file for folder in folders for file in (ROOT / folder).rglob("*.*")]
    gone = []
    for place in texts():
        text = place.read_text(encoding="utf-8")
        for name, defined in FILE_NAME.findall(text):
            files = [file for file in known if file.as_posix().endswith(f"/{name}")]
            there = any(defined in file.read_text(encoding="utf-8") for file in files)
            if not (there or name.startswith(ELSEWHERE)):
                gone.append(f"{place}: {name} {defined}")
        dotted = DOTTED_NAME.findall(text)
        gone += [f"{place}: {name}" for name in dotted if not is_defined(name)]

    assert gone == []


def is_defined(name: str) -> bool:
    """Whether the package defines dotted words.

    They are a module, or a name that a module defines.
    """
    try:
        return pkgutil.resolve_name(f"dubins_study.{name}") is not None
    except (ImportError, AttributeError):
        return False


@pytest.mark.parametrize("kind", ["nlp", "search", "qp"])
def test_the_page_of_engines_lists_the_options_that_solvers_use(generator, kind):
    """The page of engines lists the options used.

    They are read back from the page's table; an engine that no line names is left to its makers.
    """
    page = (DOCS / "engines.md").read_text(encoding="utf-8")
    assert f"```{{generated}} engine-options {kind}\n" in page
    tables = generator("package_tables")
    shown: dict[str, dict[str, dict[str, str]]] = {}
    for line in tables.options_table(kind).splitlines()[2:]:
        name, where, texts, why = (cell.strip(" `") for cell in line.strip("|").split(" | "))
        engine = shown.setdefault(name if name != "–" and name else list(shown)[-1], {})
        pairs = re.findall(r"`?([^`,]+)=([^`,]+)`?", texts)
        engine[where] = {key.strip(): value for key, value in pairs}
        assert why != "–" or where == "equal"

    for name, options in ((name, ENGINES[name].options) for name in shown):
        every = shown[name].get("every", {})
        for chosen in ("default", "equal", "tuned"):
            page_says = every | shown[name].get(chosen, {})
            assert page_says == {key: str(value) for key, value in options.of(chosen).items()}


def test_the_page_of_engines_says_what_each_is_given(generator):
    """The page of engines says what each is given.

    Every engine has a line but searches, which have one together; and every status's claim.
    """
    page = (DOCS / "engines.md").read_text(encoding="utf-8")
    section = page.split("(what-an-engine-is-given)=")[1].split("(what-a-status-claims)=")[0]
    engines = {*names(NLP, PROVEN, QP, ROOTS), *CONVEX}

    assert {name for name in engines if f"`{name}`" not in section} == set()
    table = generator("package_tables").statuses_table()
    assert all(f"`{status}`" in table for status in ("Solved", "kTimeLimit", "INFEASIBLE"))


TEXT = (DOCS / "architecture.md").read_text(encoding="utf-8")
# `room/`, `room/module.py` or `room/module.py:name`
NAMED = re.findall(r"`([\w/<>.-]+/|[\w/<>.-]+\.(?:py|toml))(?::(\w+))?`", TEXT)


def places(name: str) -> list[Path]:
    """The file or folder that a name means."""
    if name == "__init__.py":  # of every room
        return list(PACKAGE.glob("*/__init__.py"))
    root = DOCS.parent if name in ("src/dubins_study/", "pyproject.toml") else PACKAGE
    return list(root.glob(name.rstrip("/")))


@pytest.mark.parametrize(("file", "name"), sorted(set(NAMED)))
def test_what_the_architecture_names_exists(file, name):
    """A reader who follows the document arrives."""
    assert places(file), f"docs/architecture.md names {file}, which does not exist"
    if name:
        module = import_module(f"dubins_study.{file.removesuffix('.py').replace('/', '.')}")
        assert name in vars(module), f"{file} does not define {name}"


def test_the_architecture_answers_its_questions():
    """The architecture answers its questions.

    Each question has a row that names at least one file.
    """
    rows = re.findall(r"^\| (wh[^|]*\?) \|(.*)\|$", TEXT, re.M)

    assert len(rows) == 17
    assert all("`" in answer for _, answer in rows)
    assert len(NAMED) > 30


def test_one_duration_of_the_benchmark():
    """All texts tell one duration of the benchmark.

    It is that of the manifests of the committed runs.
    """
    manifests = [read_manifest(ROOT / "results" / "benchmark" / suite) for suite in SUITES]
    seconds = sum(run.seconds or 0.0 for manifest in manifests for run in manifest.runs)
    duration = f"{seconds / 60:.0f} minutes"
    texts = {
        "Makefile": r"convex problems \(([^)]*)\)",
        "CONTRIBUTING.md": r"benchmark and its report: (\w+ \w+)",
        "docs/method.md": r"committed run took (\w+ \w+)",
        "docs/running.md": r"`make benchmark` the benchmark \(([^)]*)\)",
        "docs/decisions.md": r"Why: the run takes (\w+ \w+)",
    }

    for file, pattern in texts.items():
        assert re.findall(pattern, (ROOT / file).read_text(encoding="utf-8")) == [duration], file


if __name__ == "__main__":
    print(glossary_page(), end="")
