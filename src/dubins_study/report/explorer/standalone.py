"""The explorer as a page of its own, which opens offline."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path as FilePath

from markupsafe import Markup

from dubins_study.report.explorer.fragment import fragment

SCRIPTS = (
    *("dubins", "dubins-certificate", "svg", "explorer-scene", "explorer-handles"),
    *("explorer-answers", "explorer-sweep", "explorer-copies", "explorer"),
)
_PAGE = Markup(
    '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
    '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
    '<meta name="color-scheme" content="light dark">\n<title>{title}</title>\n'
    "<style>\n{style}\n</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>\n"
    "<p>{lead}</p>\n{body}\n</main>\n{scripts}\n</body>\n</html>\n"
)
_TEMPLATES = files("dubins_study.report.page") / "templates"
_TITLE = "Explore the shortest bounded-curvature path to a point"
_LEAD = (
    "A vehicle that turns no tighter than a radius R drives from a place and heading to a target. "
    "Drag target, heading or radius: every word's path, its length and its certificate follow. "
    "Tab reaches the handles too: arrow keys move them, + and − change the radius."
)


def style() -> str:
    """The style of a page around the explorer, and the explorer's own."""
    return "\n".join(_text("styles", f"{name}.css") for name in ("base", "explorer"))


def scripts() -> list[str]:
    """The scripts that bring the explorer to life, in the order in which they run."""
    return [_text("scripts", f"{name}.js") for name in SCRIPTS]


def standalone(title: str = _TITLE, lead: str = _LEAD) -> str:
    """A whole page, with its style and its scripts inside."""
    return _PAGE.format(
        title=title,
        lead=lead,
        style=Markup(style()),
        body=fragment(),
        scripts=Markup("\n".join(f"<script>\n{text}</script>" for text in scripts())),
    )


def write_standalone(file: FilePath) -> FilePath:
    """Write the page to a file; returns the file."""
    file.write_text(standalone(), encoding="utf-8", newline="\n")
    return file


def _text(folder: str, name: str) -> str:
    return (_TEMPLATES / folder / name).read_text(encoding="utf-8")
