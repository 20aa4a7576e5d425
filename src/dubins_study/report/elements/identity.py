"""How a method is named in tables, and how a number with its interval is written."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.elements.columns import Column
from dubins_study.report.elements.formats import ABSENT, Format

FORMULATION = Column("formulation", "formulation", kind="text")
ENGINE = Column("engine", "engine", kind="text")
METHOD = (
    FORMULATION,
    ENGINE,
    Column("guess", "initial guess", kind="text"),
    Column("settings", "settings", kind="text"),
)


def method_columns(frame: pd.DataFrame) -> tuple[Column, ...]:
    """The columns that name a method; settings only if any method of the table has some."""
    return METHOD if frame["settings"].astype(bool).any() else METHOD[:-1]


def interval_columns(show: Format, key: str, title: str) -> tuple[Column, ...]:
    """Columns of a number and the ends of its 95 % interval: `key`, `key`_low and `key`_high."""
    ends = (Column(f"{key}_low", "95 %: from", show), Column(f"{key}_high", "to", show))
    return (Column(key, title, show), *ends)


def with_interval(show: Format, value: float, low: float, high: float) -> str:
    """A number and its interval as text: `2.5 (2.1 to 3.4)`; a dash if it is not known."""
    if value != value:
        return ABSENT
    return show(value) if low != low else f"{show(value)} ({show(low)} to {show(high)})"
