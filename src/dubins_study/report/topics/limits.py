"""The section on what the page's numbers are of, and the dictionary of the rows' columns."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns
from dubins_study.report.elements.content import General, Section, Table, Topic
from dubins_study.study.rows.schema import ROW, VERSION

# (what the numbers are of, what they therefore do not say)
_LIMITS = (
    (
        "One problem: a point target, any heading at the end, forward motion, constant speed, a "
        "radius that is known, neither obstacles nor wind.",
        "How formulations and engines do on other problems, above all on larger ones.",
    ),
    (
        "Scenarios that were drawn to cover cases, the awkward ones on purpose; each counts once.",
        "How often a method is right in a use, where easy targets may be the rule.",
    ),
    (
        "Engines as Python calls them, at the settings that the solvers' table names.",
        "How fast an engine is from another language, or how good with settings tuned to the task.",
    ),
    (
        "One machine kind a run, one thread for an engine, versions as under provenance.",
        "Times on other machines; with other versions verdicts may change too.",
    ),
    (
        "Verdicts against the closed form, whose formulas this package derives.",
        "That the closed form is right: the package's tests compare it with searches that know "
        "nothing of it, and the certificates prove answers from their controls alone.",
    ),
)


def limits_section(_: Results | None) -> Section:
    """What the numbers do not say; the meaning of every column of the rows."""
    lead = (
        "Read on the left what the numbers of this page are of, on the right what they leave open."
    )
    text = (
        "Below is the data dictionary: every column of the rows in a results folder's Parquet "
        f"files, schema {VERSION}."
    )
    return Section("limits", "Limits and data dictionary", text, (_limits(), _dictionary()), lead)


def _limits() -> Table:
    frame = pd.DataFrame(_LIMITS, columns=["numbers", "unknown"])
    shown = columns(kind="prose", numbers="the numbers are of", unknown="they do not say")
    return Table("limits", "What holds for the whole page.", frame, shown, stacked=True)


def _dictionary() -> Table:
    frame = pd.DataFrame(ROW, columns=list(ROW[0]._fields))
    shown = (
        *columns(kind="code", name="column"),
        *columns(kind="text", type="type", unit="unit"),
        *columns(kind="prose", meaning="meaning"),
    )
    caption = (
        "The columns of the rows. Missing and non-finite numbers are null; a unit of 1 is a share "
        "or a ratio."
    )
    return Table("columns", caption, frame, shown)


TOPIC = Topic("limits", limits_section, General.EVERY)
