"""The section on certificates: how far the proof of each answer goes."""

from __future__ import annotations

import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.data.attempts import PROOFS
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, Column, columns, marks
from dubins_study.report.elements.content import Picture, Section, Table, picture
from dubins_study.report.elements.formats import count, digits, sentences, share
from dubins_study.report.elements.identity import best_first
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.names import in_page_order, labels_of
from dubins_study.report.elements.panels import plot_shares, plot_stacked_shares
from dubins_study.report.elements.plots import DRAWN_TEXT, HIGHEST
from dubins_study.report.elements.style import BLUE, ORANGE, RULE, SKY, WIDE
from dubins_study.report.elements.topic import General, Topic
from dubins_study.report.statistics.methods import MOST_METHODS, drawn_methods
from dubins_study.report.topics.summary import best_solvers, solver_summary


def certificates_section(results: Results) -> Section | None:
    """Proofs as bars and counts, the worst residuals, and the width of the enclosures."""
    frame = in_page_order(results.attempts.proofs(), results)
    if not frame["certified"].sum():
        return None
    text = (
        "Every answer is certified from its controls alone. Proved: the length agrees with a "
        "rigorous interval around the shortest one, and Pontryagin's conditions hold, for the "
        "branch best the cut margin too; or there is provably no path, and none was returned. "
        "Bounded: the solver's own "
        "bound is within the tolerance. Extremal: Pontryagin's conditions alone, which are "
        "necessary and not sufficient."
    )
    named = frame.assign(label=frame["solver"].map(labels_of(results)))
    text = sentences(text, _proved(frame), _enclosed(frame), _reported(named))
    best = best_solvers(results)
    blocks: tuple[Table | Picture, ...] = (
        _picture(results, frame),
        *best_first(_proofs_table(frame), frame["solver"], best),
        *best_first(_table(frame), frame["solver"], best),
    )
    lead = "See how far the proof of each method's answers goes: plain blue is proved."
    return Section("certificates", "Certificates", text, blocks, lead)


def _proved(frame: pd.DataFrame) -> str:
    attempts, proved = int(frame["attempts"].sum()), int(frame["proved"].sum())
    others = ", ".join(f"{count(frame[name].sum())} {name}" for name in PROOFS[1:])
    return (
        f"Of {count(attempts)} attempts {count(proved)} are proved ({share(proved / attempts)}; "
        f"{others})."
    )


def _enclosed(frame: pd.DataFrame) -> str:
    if not frame["enclosed"].sum():
        return ""
    widest, jumps = frame["width"].max(), int(frame["open"].max())
    sentences = []
    if widest == widest:  # not NaN: some interval is narrow
        sentences.append(
            f"The widest interval around a shortest length is {digits(2)(widest)} of it: as much "
            "as the rounding of the data leaves open."
        )
    if jumps:
        sentences.append(
            f"{jumps} intervals hold the lengths on both sides of a jump, since the target is "
            "nearer to a turning circle, or to the axis, than the data can tell."
        )
    return " ".join(sentences)


def _reported(frame: pd.DataFrame) -> str:
    parts = []
    compared = frame[frame["multipliers"] > 0]
    if len(compared):
        ranked = compared.sort_values("costate_error").to_dict("records")
        best, worst = ranked[0], ranked[-1]
        part = (
            "the multipliers of an extremal are off its own costates by at most "
            f"{digits(2)(worst['costate_error'])} ({worst['label']}, whose median is "
            f"{digits(2)(worst['costate_median'])})"
        )
        if len(compared) > 1:
            part += f", at best by {digits(2)(best['costate_error'])} ({best['label']})"
        parts.append(part)
    if bounds := int(frame["bounds"].sum()):
        false = int(frame["false_bounds"].sum())
        parts.append(
            f"of {count(bounds)} lower bounds {count(false)} lie above the shortest length"
        )
    return f"What solvers report in addition to a path: {'; '.join(parts)}." if parts else ""


def _picture(results: Results, frame: pd.DataFrame) -> Picture:
    caption = (
        "How far the proof of each attempt goes, as shares of all attempts. A failed or coarse "
        "answer has none, nor has one whose controls ripple about an extremal's, nor what the "
        "presolve answered in an engine's place."
    )
    alt = "Stacked bars of proofs, one per solver"
    if len(frame) > MOST_METHODS:
        drawn = drawn_methods(solver_summary(results.attempts))
        proofs = frame.set_index("solver").reindex(drawn["solver"]).reset_index()
        shares = proofs[list(PROOFS)].div(proofs["attempts"], axis=0)
        named = drawn[["formulation", "short"]].reset_index(drop=True)
        figure = plot_stacked_shares(shares.join(named), _LOOK, "share of all attempts")
        return Picture("certificates", f"{caption} {DRAWN_TEXT}", figure, alt)
    return picture(
        "certificates",
        plot_proofs,
        *(frame, Palette.of_page(results)),
        caption=caption,
        alt=alt,
        height=min(HIGHEST, 0.9 + 0.3 * len(frame)),
        width=WIDE,
    )


# From dark to light, weaker proofs hatched, so that grey print keeps the order.
_LOOK = {
    "proved": (BLUE, ""),
    "bounded": (SKY, "\\\\"),
    "extremal": (ORANGE, "///"),
    "none": (RULE, "xx"),
}


def plot_proofs(ax: Axes, table: pd.DataFrame, palette: Palette) -> None:
    """Draw the share of each proof, one bar per solver. Columns solver, attempts, each proof."""
    look = {name: _LOOK[name] for name in PROOFS}
    notes = [f"of {count(attempts)}" for attempts in table["attempts"]]
    plot_shares(ax, table, look, notes, palette)
    ax.figure.legend(loc="outside lower left", ncols=4)


def _proofs_table(frame: pd.DataFrame) -> Table:
    shown = (
        SOLVER,
        *columns(count, attempts="attempts"),
        *(Column(name, name, count) for name in PROOFS),
        *columns(count, bounds="lower bounds", false_bounds="false bounds"),
    )
    caption = (
        "Attempts by how far their proof goes; bounds that solvers report, and how many of them "
        "lie above the shortest length."
    )
    return Table("proof-counts", caption, frame, shown, marks(frame, "false_bounds"))


def _table(frame: pd.DataFrame) -> Table:
    number = digits(2)
    shown = (
        SOLVER,
        *columns(number, pmp_residual="worst residual", cut_margin="least cut margin, rad"),
        *columns(count, multipliers="multipliers"),
        *columns(number, costate_median="costate error, median", costate_error="worst"),
    )
    caption = (
        "Residual: the worst violation of Pontryagin's conditions among the optimal answers. Cut "
        "margin: above 0 a path is the shortest to its own end; the least among the optimal "
        "answers to the branch best. Costate error: the distance of a solver's multipliers from "
        "the costates of its own path, where that arrives and is an extremal of more than one "
        "arc: a single arc does not determine them."
    )
    return Table("certificates", caption, frame, shown)


TOPIC = Topic("certificates", certificates_section, General.POOLED, counted=True)
