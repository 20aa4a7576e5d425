"""Write the report: figures, tables and self-contained pages."""

from __future__ import annotations

import gc
import tempfile
from collections.abc import Callable, Iterable, Sequence
from itertools import chain
from pathlib import Path as FilePath
from typing import Any, NamedTuple

from jinja2 import Template
from markupsafe import Markup

from dubins_study.errors import DubinsStudyError
from dubins_study.report.data.rejudged import Recheck
from dubins_study.report.data.results import Folder, Results, load_with_rows
from dubins_study.report.elements import style
from dubins_study.report.elements.content import Picture, Place, Section, Table
from dubins_study.report.elements.formats import count, sentences, some
from dubins_study.report.elements.style import figure_bytes, fix_layout
from dubins_study.report.page.environment import (
    FRONT_PAGE,
    PAPER_PAGE,
    environment,
    scripts,
    styles,
)
from dubins_study.report.page.glossary import WORDS
from dubins_study.report.page.markup import dictionary, inline, to_csv, to_tex
from dubins_study.report.page.sections import KEYS, TOPICS, sections_of
from dubins_study.report.paper.printed import CITATION, TITLE
from dubins_study.report.topics.appendix import limits_section
from dubins_study.report.topics.failures import failures_section
from dubins_study.study.rows.parts import folder_paths


class Head(NamedTuple):
    """A page's heading, and the question below it.

    `asked` is one or more sentences.
    """

    heading: str
    asked: str


_TITLE = "The shortest path of a vehicle that cannot turn tightly"
_ASKED = (
    "A vehicle starts at a place with a heading, the direction in which it drives, and must reach "
    "a target. Which solvers (programs for optimisation) find its shortest path, and which only "
    "say so?"
)


def head_of(folders: Sequence[Folder]) -> Head:
    """The heading and the question of the page.

    They are those of the experiment, or the report's own if the folders hold several experiments.
    """
    first = folders[0]
    if len({folder.name for folder in folders}) > 1:
        return Head(_TITLE, _ASKED)
    return Head(first.title, first.manifest.experiment.question or _ASKED)


Progress = Callable[[str], None]


class ReportError(DubinsStudyError, ValueError):
    """A report cannot be written to this place."""


def render(
    folders: Iterable[str | FilePath] | str | FilePath,
    out: str | FilePath | None = None,
    progress: Progress | None = None,
) -> FilePath:
    """Write the report of one or more results folders.

    Returns the path of `index.html`.

    Args:
        folders: one or more results folders, or folders of results folders.
        out: the folder to write to; None: `report` inside the first folder. An earlier
            report there is replaced in one step, once the new one is complete.
        progress: called with the title of each section before the section is drawn.

    Raises:
        ResultsError: if a folder cannot be read.
        ReportError: if `out` cannot be written.
    """
    paths = folder_paths(folders)
    # A report makes millions of objects and few reference cycles: with Python's own thresholds the
    # search for cycles takes a sixth of the time.
    thresholds = gc.get_threshold()
    gc.set_threshold(100_000, 50, 100)
    try:
        results, empty = load_with_rows(paths)
        if out is None:
            out = paths[0] / "report"
        every_folder = empty
        if results is not None:
            every_folder = (*results.folders, *empty)
        head = head_of(every_folder)
        return write_page(out, lambda: _sections(results, progress), every_folder, head)
    finally:
        gc.set_threshold(*thresholds)


def write_page(
    out: str | FilePath,
    draw: Callable[[], Sequence[Section]],
    folders: Sequence[Folder],
    head: Head,
) -> FilePath:
    """Write sections as a page, tables and figures.

    `draw` makes the sections; it is called after a check that the folder `out` can be written.
    `folders` are the results folders that the page is about. An earlier report in `out` is replaced
    in one step. The path of `index.html` comes back. A `ReportError` says why `out` cannot be
    written.
    """
    target = FilePath(out)
    try:
        _check_target(target)
        with style.drawing():
            sections = draw()
            target.parent.mkdir(parents=True, exist_ok=True)
            _write_whole(target, sections, folders, head)
    except OSError as error:  # e.g. the name is too long, or the folder may not be read
        raise ReportError(f"{target} cannot be written: {error.strerror or error}") from None
    return target / FRONT_PAGE


# Names of all files and folders of a report. A folder that holds anything else is never replaced.
_WRITTEN = {FRONT_PAGE, PAPER_PAGE, "figures", "tables"}
_EARLIER = {"report.md", "report.tex"}  # of earlier versions
_SIGN = FilePath("tables", "dictionary.csv")  # a folder with this file is a report


def _check_target(target: FilePath) -> None:
    """Raise an error unless a report may replace `target`.

    The target may be missing, an empty folder, or a folder with an earlier report and nothing else.
    """
    if not target.exists():
        return
    if not target.is_dir():
        raise ReportError(f"{target} is a file; expected a folder to write the report to")
    others = {entry.name for entry in target.iterdir()}
    if (target / _SIGN).exists():
        others -= _WRITTEN | _EARLIER
    if others:
        raise ReportError(
            f"{target} holds {min(others)!r}, no part of a report; expected an empty folder"
        )


def _sections(results: Results | None, progress: Progress | None) -> list[Section]:
    """The sections of the report, in page order."""
    if results is None:
        return [_without_rows(), failures_section(None), limits_section(None)]
    sections: list[Section] = []
    for topic in TOPICS:
        if progress is not None:
            progress(topic.title)
        sections += sections_of(topic, results)
    return sections


def _without_rows() -> Section:
    text = (
        "No solver's answer was recorded: the run has not begun, was stopped before its first "
        "answer, or every solver was left out. Run dubins-study status on the folder. Then run "
        "the command below again; it continues where it stopped."
    )
    return Section("decision", "No rows", text, (), "There is nothing to report yet.")


def _write_whole(
    target: FilePath, sections: Sequence[Section], runs: Sequence[Folder], head: Head
) -> None:
    """Write all files, then rename them to `target`.

    They are written to a temporary folder beside the target, which is then renamed. A reader never
    sees an incomplete report.
    """
    with tempfile.TemporaryDirectory(
        prefix=f".{target.name}-", dir=target.parent, ignore_cleanup_errors=True
    ) as place:
        fresh = FilePath(place, "new")
        old = FilePath(place, "old")
        fresh.mkdir()
        _write(fresh, sections, runs, head)
        if target.exists():
            target.rename(old)
        fresh.rename(target)


def _write(
    folder: FilePath, sections: Sequence[Section], runs: Sequence[Folder], head: Head
) -> None:
    """Write tables, figures and pages into an empty folder."""
    for name in ("figures", "tables"):
        (folder / name).mkdir()
    blocks = list(chain.from_iterable(section.blocks for section in sections))
    tables = [block for block in blocks if isinstance(block, Table)]
    for table in (*tables, dictionary(sections)):
        for suffix, to_text in (("csv", to_csv), ("tex", to_tex)):
            _write_text(folder / "tables" / f"{table.name}.{suffix}", to_text(table))
    elements: dict[str, Markup] = {}
    for block in blocks:
        if isinstance(block, Picture):
            elements |= _write_picture(block, folder / "figures")
    places = {place: [section for section in sections if section.place is place] for place in Place}
    paper = places[Place.PAPER]
    content = {
        "sections": sections,
        "runs": runs,
        "drawn": elements,
        "citation": CITATION,
        "paper_title": TITLE,
        "glossary": WORDS,
        "style": styles(),
        "scripts": scripts(),
        **head._asdict(),
    }
    front: dict[str, Any] = {
        "page": FRONT_PAGE,
        "open": places[Place.FRONT],
        "details": places[Place.DETAILS],
        "others": [],
    }
    pages = [front]
    if paper:
        front["others"] = [(PAPER_PAGE, "The paper, recomputed")]
        about_paper = {
            "page": PAPER_PAGE,
            "open": paper,
            "details": [],
            "others": [(FRONT_PAGE, "The study")],
        }
        pages.append(about_paper)
    for page in pages:
        _write_text(folder / page["page"], _template().render(**content, **page))


def _write_picture(picture: Picture, folder: FilePath) -> dict[str, Markup]:
    """Write a figure's files; return its HTML elements.

    The files are SVG and PDF, in `folder`. The elements are by name: the wide figure's, and
    `NAME-narrow` if the picture has a narrow one.
    """
    fix_layout(picture.figure)
    svg = figure_bytes(picture.figure, "svg")
    (folder / f"{picture.name}.svg").write_bytes(svg)
    (folder / f"{picture.name}.pdf").write_bytes(figure_bytes(picture.figure, "pdf"))
    elements = {picture.name: inline(svg.decode("utf-8"), picture.name, picture.alt)}
    if picture.narrow is not None:
        fix_layout(picture.narrow)
        name = f"{picture.name}-narrow"
        svg = figure_bytes(picture.narrow, "svg")
        elements[name] = inline(svg.decode("utf-8"), name, picture.alt)
    return elements


def _write_text(file: FilePath, text: str) -> None:
    file.write_text(text, encoding="utf-8", newline="\n")


def _template() -> Template:
    """A fresh template, to render one page.

    A template links only the first use of a word of the glossary, so each page needs its own.
    """
    templates = environment()
    templates.filters |= {"left_out": left_out, "warnings": warnings, "differing": differing}
    return templates.get_template("index.html.j2")


def warnings(run: Folder) -> list[str]:
    """Warnings about a folder's numbers; often none."""
    lines = []
    if not run.rows.current:
        lines.append("It has no rows, so no number here comes from it.")
    if not run.manifest.finished:
        lines.append("Not finished: the numbers below count only the cells done so far.")
    if run.rows.contradicting:
        lines.append(
            f"It contradicts an earlier folder in {some(run.rows.contradicting, 'cell')}, with the "
            "same code. The earlier folder's attempts are shown; dubins-study merge names both."
        )
    if run.rows.other_limits:
        lines.append(f"{run.rows.limits_text}.")
    if run.recheck is not None and run.recheck.changed:
        lines.append(f"Made elsewhere, and judged anew: {differing(run.recheck)}.")
    if run.section is not None and run.section not in KEYS:
        lines.append(
            f"Its TOML file asks for the section {run.section!r}, which the report does not have; "
            f"expected one of: {', '.join(KEYS)}."
        )
    return lines


def differing(recheck: Recheck) -> str:
    """A sentence on how many rows are judged differently.

    The check here judged rows of another set-up anew. Its verdicts are compared with those of the
    folder, column by column.
    """
    listed = ", ".join(f"{name} {count(n)}" for name, n in recheck.differing.items())
    if listed:
        listed = f" ({listed})"
    unchecked = ""
    if recheck.left:
        unchecked = f"({some(recheck.left, 'answer')} to convex problems are not judged anew)"
    return sentences(
        f"{some(recheck.changed, 'row')} of {count(recheck.judged)} differ from what the folder "
        f"says{listed}",
        unchecked,
    )


def left_out(run: Folder) -> list[str]:
    """How many rows the report leaves out, and why.

    A text for each reason; empty if the report shows all rows of the folder.
    """
    lines = {
        "of earlier code of their solvers": run.rows.stale,
        "of cells that an earlier folder has, made by other code": run.rows.replaced,
    }
    return [f"{some(number, 'row')} {reason}" for reason, number in lines.items() if number]
