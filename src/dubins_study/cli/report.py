"""`dubins-study report`: tables, figures and one page.

They are made from results folders.
"""

from __future__ import annotations

import json
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Annotated

import typer

from dubins_study.cli.terminal import output
from dubins_study.cli.terminal.output import plain

if TYPE_CHECKING:
    import pandas as pd

# Column of the report's summary -> its name in the terminal; only columns that fit a terminal.
_SUMMARY = {
    "solver": "solver",
    "right_text": "right of n, 95 %",
    "longer": "longer",
    "misses": "misses",
    "none": "none",
    "false_claims": "false claims",
    "wrong_basins": "wrong basins",
    "wall_s": "median ms",
}


def report(
    folders: Annotated[
        list[FilePath], typer.Argument(metavar="DIR", help="results folders, or folders of them")
    ],
    out: Annotated[
        FilePath | None, typer.Option(metavar="DIR", help="default: report in the first folder")
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="print page and summary as one JSON object")
    ] = False,
) -> None:
    """Write tables, figures and one page from results folders."""
    from dubins_study.report.page.render import render

    with output.steps("report") as step:
        page = render(folders, out=out, progress=step)
    if as_json:
        print(report_json(page))
    else:
        print(report_text(page))


def _summary(page: FilePath) -> pd.DataFrame:
    """The summary table of a report.

    The table is empty if the report's folders hold no rows.
    """
    import pandas as pd

    file = page.parent / "tables" / "summary.csv"
    if not file.exists():
        return pd.DataFrame()
    return pd.read_csv(
        file,
        keep_default_na=False,
        na_values=[""],
        dtype_backend="numpy_nullable",  # a column of counts with gaps stays one of whole numbers
    )


def report_json(page: FilePath) -> str:
    """The page's path and the summary as JSON text.

    The summary has the columns of tables/summary.csv.
    """
    frame = _summary(page)
    values = frame.astype(object).where(frame.notna(), None)
    return json.dumps({"page": str(page), "summary": values.to_dict("records")}, indent=2)


def report_text(page: FilePath) -> str:
    """The summary table and the page's path."""
    frame = _summary(page)
    if "wall_s" in frame:
        frame["wall_s"] = (frame["wall_s"] * 1e3).map("{:.3g}".format, na_action="ignore")
    # the report leaves out a column that its runs do not need
    titles = {name: title for name, title in _SUMMARY.items() if frame.empty or name in frame}
    rows = frame.reindex(columns=list(titles)).astype(object).fillna("").astype(str)
    lines = rows.replace(r"[\n\u202f]", " ", regex=True).to_numpy().tolist()
    return f"{output.table(list(titles.values()), lines)}\n\npage: {plain(str(page))}"
