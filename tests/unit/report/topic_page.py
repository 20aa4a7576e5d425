"""Pages of a few topics, for their tests.

Pages can have PDF files.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path as FilePath

import pytest
from matplotlib.figure import Figure

from dubins_study import render
from dubins_study.report.elements.style import figure_bytes
from dubins_study.report.page.sections import TOPICS


def topic_page(folders: FilePath | list[FilePath], out: FilePath, *titles: str) -> FilePath:
    """`index.html` of a report with these topics alone.

    It is written like any other. Whole pages of many kinds of rows are drawn in `test_page.py` and
    `test_page_parts.py`; a whole page for each topic would cost its thirty neighbours each time.
    """
    topics = tuple(topic for topic in TOPICS if topic.title in titles)
    assert len(topics) == len(titles), f"no topic is called one of {titles}"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("dubins_study.report.page.render.TOPICS", topics)
        return render(folders, out)


@contextmanager
def with_pdf_files() -> Iterator[None]:
    """Draw the PDF files of figures too.

    The fixture `svg_alone` leaves them out.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("dubins_study.report.page.render.figure_bytes", figure_bytes)
        yield


@contextmanager
def without_pdf_files() -> Iterator[None]:
    """Draw figures as SVG alone.

    Fonts are cut for every PDF anew: a third of what a page costs.
    """

    def drawn(figure: Figure, kind: str) -> bytes:
        return b"%PDF" if kind == "pdf" else figure_bytes(figure, kind)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("dubins_study.report.page.render.figure_bytes", drawn)
        yield
