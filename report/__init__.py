"""The report: rows to numbers, numbers to tables and figures, and one page."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from report.load import ReportError
    from report.page import render

__all__ = ["ReportError", "render"]


def __getattr__(name: str) -> Any:
    # matplotlib is slow to import, and `dubins-study --help` must not wait for it
    if name == "render":
        from report.page import render

        return render
    if name == "ReportError":
        from report.load import ReportError

        return ReportError
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
