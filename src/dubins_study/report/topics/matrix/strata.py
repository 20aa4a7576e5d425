"""Right answers by stratum: a table, and a map for each formulation."""

from __future__ import annotations

import json
from collections.abc import Collection

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import Column, columns
from dubins_study.report.elements.content import Picture, Table, picture
from dubins_study.report.elements.formats import slug
from dubins_study.report.elements.identity import best_first
from dubins_study.report.topics.matrix.figures import plot_strata
from dubins_study.report.topics.matrix.heatmap import whole_percent


def strata_blocks(
    results: Results, methods: pd.DataFrame, shares: pd.DataFrame, best: Collection[str]
) -> list[Picture | Table]:
    """The shares of `numbers.strata` as maps and as a table; nothing if there is one stratum."""
    names = stratum_order(results, shares["stratum"].unique().tolist())
    if len(names) < 2:
        return []
    methods = methods.assign(few=methods["right_of"] < methods["right_of"].max() / 2)
    wide = shares.pivot(index="solver", columns="stratum", values="right_share")[names]
    pictures = [
        _picture(str(formulation), group, wide, first=place == 0)
        for place, (formulation, group) in enumerate(methods.groupby("formulation", sort=False))
        if formulation != "closed form"
    ]
    table = _table(methods, shares, names)
    return [*pictures, *best_first(table, table.frame["solver"], best)]


def stratum_order(results: Results, names: list[str]) -> list[str]:
    """Labels of scenarios in the order in which the experiments' files name them."""
    text = "\n".join(folder.manifest.experiment.text for folder in results.folders)
    places = {name: text.find(json.dumps(name)) for name in sorted(names)}
    return sorted(places, key=lambda name: (places[name] < 0, places[name]))


def _picture(
    formulation: str, methods: pd.DataFrame, wide: pd.DataFrame, *, first: bool
) -> Picture:
    few = methods["few"].any()
    shares = wide.reindex(methods["solver"]).set_axis(_names(methods), axis=0)
    return picture(
        f"strata-{slug(formulation)}",
        plot_strata,
        shares,
        caption=f"{formulation[0].upper()}{formulation[1:]}: percent right in each stratum."
        f"{' A star: asked less than half as many questions.' if few else ''}",
        alt=f"Map of right answers of {formulation}, methods by strata",
        height=1.35 + 0.145 * len(shares),
    )


def _names(methods: pd.DataFrame) -> list[str]:
    """Engines, with what else tells the methods of a formulation apart: short, for small maps."""
    several = len(set(methods["guess"]) - {"none"}) > 1
    names = []
    for row in methods.to_dict("records"):
        guess = row["guess"] if several and row["guess"] != "none" else ""
        settings = row["settings"].replace("presolve", "presolved")
        star = " *" if row["few"] else ""
        names.append(", ".join(filter(None, (row["engine"], guess, settings))) + star)
    return names


def _table(methods: pd.DataFrame, shares: pd.DataFrame, names: list[str]) -> Table:
    texts = shares.assign(
        text=[
            f"{whole_percent(value)} %\n{whole_percent(low)}–{whole_percent(high)}"
            for value, low, high in zip(
                shares["right_share"], shares["right_low"], shares["right_high"], strict=True
            )
        ]
    ).pivot(index="solver", columns="stratum", values="text")
    frame = methods[["formulation", "engine", "guess", "settings", "solver"]].merge(
        texts.reset_index(), on="solver"
    )
    frame["guess"] = [
        ", ".join(filter(None, pair))
        for pair in zip(frame["guess"], frame["settings"], strict=True)
    ]
    shown = (
        *columns(kind="text", formulation="formulation", engine="engine"),
        *columns(kind="text", guess="guess and settings"),
        *(Column(name, name, kind="cell") for name in names),
    )
    caption = (
        "Questions answered right, stratum by stratum, with the 95 % interval (Wilson, a trial a "
        "question)."
    )
    return Table("strata", caption, frame, shown, numbers=("solver",), dense=True)
