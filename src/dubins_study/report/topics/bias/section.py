"""The section on the interior-point bias in the segments."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, columns
from dubins_study.report.elements.content import Picture, Section, Table, picture
from dubins_study.report.elements.formats import count, digits
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.topic import Topic
from dubins_study.report.statistics.metrics import parse_spec
from dubins_study.report.topics.bias import numbers
from dubins_study.report.topics.bias.figures import plot_bias, plot_left_over

_FOLLOWS = 0.1  # largest |ratio - 1| that confirms the prediction


def bias_section(results: Results) -> Section | None:
    """The remaining turn against its prediction, and the turn that other methods leave."""
    table = numbers.left_over(results)
    table = table[(table["branch"] == "best") & table["z2"].notna()]
    with_barrier = table[table["mu"].notna()]
    if with_barrier.empty:
        return None
    barriers, others = numbers.by_barrier(table), numbers.without_barrier(table)
    palette = Palette.of_page(results)
    sentences = [
        *(_prediction(with_barrier, barriers), *_default(with_barrier, palette)),
        *_others(others),
    ]
    text = (
        "The shortest path to this target is LS, and the paper's model L(z₁) R(z₂) S(z₃) should "
        "answer with z₂ = 0. There its reduced cost is zero: the length grows only like "
        "z₂³ / (3 R²), so a barrier −μ ln z₂ stops the turn at z₂ = (μ R²)^(1/3), where the "
        f"length is μ / 3 too long. {' '.join(sentences)}"
    )
    compared = table[~table["barrier_set"]]
    blocks: list[Picture | Table] = [_bias_picture(with_barrier)]
    if len(compared):
        blocks.append(_left_over_picture(compared, palette))
    blocks.append(_barrier_table(barriers))
    if len(others):
        blocks.append(_other_table(others))
    lead = (
        "Marks on the dashed line confirm the prediction: how much turn an interior-point solver "
        "leaves in a path that should have none, while its length shows nothing."
    )
    return Section("bias", "The interior-point bias in the segments", text, tuple(blocks), lead)


def _prediction(with_barrier: pd.DataFrame, barriers: pd.DataFrame) -> str:
    deviation, slope = numbers.prediction_fit(with_barrier)
    comparison = f"is within a relative {digits(2)(deviation)} of this"
    if deviation > _FOLLOWS:
        away = f"up to a relative {digits(2)(deviation)} away"
        comparison = f"does not follow this everywhere: it is {away}"
    failed = int(barriers["failed"].sum())
    failures = f", though the solver calls {failed} of them failures" if failed else ""
    return (
        f"Over {count(len(with_barrier))} attempts z₂ {comparison}; the slope in logarithms is "
        f"{digits(5)(slope)}{failures}."
    )


def _default(with_barrier: pd.DataFrame, palette: Palette) -> list[str]:
    """One sentence on the radius nearest to 1, if the defaults were tried."""
    row = numbers.default_attempt(with_barrier)
    if row is None:
        return []
    (name,) = palette.names([row["solver"]]).values()
    return [
        f"By its defaults {name} stops at μ = {digits(3)(row['mu'])}: at "
        f"R = {row['radius']:g} it leaves z₂ = {digits(4)(row['z2'])} where "
        f"{digits(4)(row['predicted'])} is predicted, while the length is only "
        f"{digits(2)(max(row['gap'], 0.0))} of itself too long and shows nothing."
    ]


def _others(others: pd.DataFrame) -> list[str]:
    if others.empty:
        return []
    joint, split = others[others["joint"]], others[~others["joint"]]
    clauses = []
    if len(joint):
        name = " and ".join(sorted({parse_spec(spec)[0] for spec in joint["solver"]}))
        exact, tried = int(joint["exact"].sum()), int(joint["attempts"].sum())
        clauses.append(
            f"on this model {name} leaves no turn in {exact} of {tried} attempts"
            + (f" and up to {digits(2)(joint['most'].max())} R in the others" * (exact < tried))
        )
    if len(split):
        exact, tried = int(split["exact"].sum()), int(split["attempts"].sum())
        clauses.append(
            "with one turn fixed at zero, as the paper's Algorithm 1 does, the other turn is left "
            f"out exactly in {exact} of {tried}"
        )
    text = "; ".join(clauses)
    return [f"{text[:1].upper()}{text[1:]}."]


def _bias_picture(with_barrier: pd.DataFrame) -> Picture:
    caption = (
        "The turn that Ipopt leaves, against the cube root of barrier times radius squared; one "
        "mark per attempt. On the dashed line they are equal."
    )
    alt = "Turn left over against its prediction"
    return picture("bias", plot_bias, with_barrier, caption=caption, alt=alt, height=3.9, legend=1)


def _left_over_picture(compared: pd.DataFrame, palette: Palette) -> Picture:
    return picture(
        "bias-methods",
        plot_left_over,
        *(compared, palette),
        caption="What methods leave that are told no barrier, in radii; at the foot those that "
        "leave no such turn at all.",
        alt="Turn left over by method and radius",
        height=2.9 + 0.16 * compared["solver"].nunique(),
        legend=1,
    )


def _barrier_table(barriers: pd.DataFrame) -> Table:
    table = barriers.assign(by=barriers["barrier_set"].map({True: "told", False: "its defaults"}))
    shown = (
        *columns(digits(3), mu="μ"),
        *columns(kind="text", by="chosen by"),
        *columns(count, attempts="radii"),
        *columns(digits(5), slope="slope", ratio_low="z₂ / predicted, least", ratio_high="most"),
        *columns(digits(3), excess_low="excess / (μ/3), least", excess_high="most"),
        *columns(count, failed="“failed”"),
    )
    caption = (
        "Ipopt by the barrier that it stops at, over the radii: slope of log z₂ against the "
        "prediction's logarithm, ratio of z₂ to it, and by how much the path is longer than the "
        "shortest, over μ / 3. In quotation marks: attempts that the solver calls failed."
    )
    return Table("bias", caption, table, shown)


def _other_table(others: pd.DataFrame) -> Table:
    shown = (
        SOLVER,
        *columns(count, attempts="radii", exact="no turn at all"),
        *columns(digits(2), least="least z₂ / R", most="most", gap="largest gap"),
        *columns(count, limits="stopped by a limit"),
    )
    caption = (
        "Methods that are told no barrier. On the unsplit model (joint) a multiplier of zero gives "
        "an active-set method no reason to put the turn at its bound."
    )
    return Table("bias-methods", caption, others, shown)


TOPIC = Topic("the interior-point bias", bias_section, "bias")
