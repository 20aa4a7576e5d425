"""The methods that are compared.

Their names, and the attempts by which they are compared.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, wraps
from itertools import chain
from typing import TypeVar
from weakref import WeakKeyDictionary

import numpy as np
import pandas as pd

from dubins_study.report.data.attempts import EXACT, TRIAL, own, own_name, presolved
from dubins_study.report.data.results import Results
from dubins_study.report.statistics.intervals import Statistic, bootstrap, scenario_shares
from dubins_study.report.statistics.metrics import natural, parse_spec, success
from dubins_study.study.rows.schema import ROW
from dubins_study.study.words import FORMULATIONS

UNSTATED = "not stated"
_STATED = ["formulation", "engine", "guess"]
# It belongs to the formulation: engines with it and without it solve different problems.
_PRESOLVE = "presolve"
# Guesses that a name leaves out if an engine and a formulation have no other.
_USUAL = ("none", "bearing", "warm", UNSTATED)
_GUESSES = ("none", "bearing", "zero", "random", "warm", "given")


def methods_of(rows: pd.DataFrame) -> pd.DataFrame:
    """The methods of attempts, in the order of tables.

    Rows of attempts that failed may lack a method's columns; another row of the solver gives them.

    Returns:
        Indexed by solver. Columns formulation, engine, guess; settings: those of the spec that
        distinguish solvers with the same three (the solver's name if it states no engine; the
        engine of a plug-in's solver is its own name, and such solvers come first), and the presolve
        where it distinguishes solvers of the formulation; variant: guess and settings, the guess
        only where it is unusual or not the only one; short: engine and variant, for a figure of one
        formulation; name: for sentences, with formulation and guess.
    """
    stated = rows.groupby("solver", observed=True)[_STATED].first().fillna(UNSTATED)
    names = stated.index.map(own_name).to_series(stated.index)
    stated["engine"] = names.where(names != "", stated["engine"])
    # A warm question's path is the question's own guess, not the method's.
    base_guess = stated["guess"].str.replace(" or warm", "", regex=False)
    settings = _settings_texts(stated, base_guess)
    frame = stated.assign(settings=[settings[spec] for spec in stated.index])
    guesses = base_guess.groupby([frame["formulation"], frame["engine"]]).transform("nunique")
    starts = base_guess.replace("none", "no") + " start"
    guess = starts.where((guesses > 1) | ~base_guess.isin(_USUAL), "")
    variant = _joined(guess, frame["settings"])
    frame = frame.assign(variant=variant, short=_joined(frame["engine"], variant))
    stated_guess = frame["guess"].where(frame["guess"] != "none", "")
    details = _joined(stated_guess, frame["settings"])
    frame["name"] = [*map(_sentence_name, frame["engine"], details, frame["formulation"])]
    order = frame.assign(
        others=names == "",
        formulation=_places(frame["formulation"], FORMULATIONS),
        guess=_places(base_guess, _GUESSES),
        engine=frame["engine"].str.casefold(),
        settings=_places(frame["settings"], sorted(set(frame["settings"]), key=natural)),
        spec=_places(frame.index.to_series(), sorted(frame.index, key=natural)),
    )
    return frame.loc[order.sort_values(["others", *_STATED, "settings", "spec"]).index]


def _settings_texts(stated: pd.DataFrame, guesses: pd.Series[str]) -> dict[str, str]:
    """The settings of each spec that its name shows."""
    presolves = {}
    for name, group in stated.groupby("formulation"):
        keys = _differing_keys([parse_spec(spec)[1] for spec in group.index])
        presolves[str(name)] = keys & {_PRESOLVE}
    texts: dict[str, str] = {}
    methods = stated.groupby([stated["formulation"], stated["engine"], guesses], sort=False)
    for (formulation, engine, _), group in methods:
        also = presolves[str(formulation)]
        texts |= _differing(group.index.tolist(), named=engine == UNSTATED, also=also)
    return texts


def _sentence_name(engine: str, details: str, formulation: str) -> str:
    """A method's name in a sentence."""
    if details:
        engine += f" ({details})"
    return f"{engine} on {formulation}"


def _joined(*texts: pd.Series[str]) -> pd.Series[str]:
    """Texts joined by commas, without empty ones."""
    lines = zip(*texts, strict=True)
    return pd.Series(
        [", ".join(filter(None, line)) for line in lines], texts[0].index, dtype=object
    )


def best_methods(frame: pd.DataFrame, keys: list[str]) -> pd.DataFrame:
    """The best-supported method of each group.

    The fastest where several have equal support. The lower end of the share's interval decides: a
    few questions, all right, support a method less than many questions, nearly all right.

    The frame has a row per method with the columns `keys`, e.g. formulation and engine, right_low
    (of the share of right answers) and wall_s (median time); returned are some of its rows, in its
    order.
    """
    ranked = _ranked(frame.reset_index(drop=True))
    places = ranked.drop_duplicates(keys).index
    return frame.iloc[sorted(places)]


def _ranked(frame: pd.DataFrame, low: str = "right_low") -> pd.DataFrame:
    return frame.sort_values([low, "wall_s"], ascending=[False, True], kind="stable")


def by_support(rows: pd.DataFrame, keys: list[str]) -> pd.DataFrame:
    """The methods of attempts, the best supported first.

    The attempts are `Compared.rows`. As `scenario_shares` by the keys, a trial a question, with
    wall_s, the median time (s).
    """
    shares = scenario_shares(rows, by=keys, success="right", scenario=["question"])
    times = rows.groupby(keys, observed=True)["wall_s"].median()
    return _ranked(shares.assign(wall_s=times), "low")


# At most this many methods have a bar or a curve each in one figure. Of more, only the best of each
# engine are drawn, and at most `MOST_ENGINES` of a formulation.
MOST_METHODS = 14
MOST_ENGINES = 10


def drawn_methods(frame: pd.DataFrame) -> pd.DataFrame:
    """The methods that figures by formulation show.

    They are the `best_methods` of engines. At most `MOST_ENGINES` of a formulation, plug-ins' and
    the best supported; not the closed form, to which no engine compares, unless there is no other.
    """
    engines = frame[frame["formulation"] != FORMULATIONS[0]]
    if engines.empty:
        engines = frame
    best = best_methods(engines, ["formulation", "engine"])
    best = best.assign(place=range(len(best)))
    ranked = _ranked(best).sort_values(  # plug-ins' solvers first
        "solver", key=lambda solvers: solvers.map(own_name).eq(""), kind="stable"
    )
    drawn = ranked.groupby("formulation", sort=False).head(MOST_ENGINES)
    return drawn.sort_values("place", kind="stable").drop(columns="place")


def foremost(scores: pd.Series[float], most: int = MOST_ENGINES) -> list[str]:
    """Solvers whose curves are in colour.

    They are plug-ins' and those with the largest scores, in the order of the index. A figure draws
    their curves in colour and the others in grey.
    """
    best = scores.sort_values(ascending=False, kind="stable").index
    chosen = set([*own(best), *best][:most])
    return [str(name) for name in scores.index if name in chosen]


def _differing_keys(settings: list[dict[str, str]]) -> set[str]:
    """The settings that some specs have otherwise than others."""
    keys = set[str]().union(*settings)
    return {key for key in keys if len({group.get(key) for group in settings}) > 1}


def _differing(specs: list[str], *, named: bool, also: set[str]) -> dict[str, str]:
    """Texts of the settings that specs do not share.

    For each spec; with the name if specs differ in it, and with the settings `also`.
    """
    parsed = [parse_spec(spec) for spec in specs]
    keys = dict.fromkeys(chain.from_iterable(settings for _, settings in parsed))
    differing = _differing_keys([settings for _, settings in parsed]) | also
    shown = [key for key in keys if key in differing]
    several_names = named or len({name for name, _ in parsed}) > 1
    texts = {}
    for spec, (name, settings) in zip(specs, parsed, strict=True):
        items = [_setting_text(key, settings[key]) for key in shown if key in settings]
        if several_names:
            items.insert(0, name)
        texts[spec] = ", ".join(items)
    return texts


def _setting_text(key: str, value: str) -> str:
    """A setting as it stands in a name.

    A switch by its name, anything else with its value, e.g. `tol=1e-8`.
    """
    switch = {"true": key, "false": f"{key} off"}
    return switch.get(value.lower(), f"{key}={_ZEROS.sub('', value.lower())}")


_ZEROS = re.compile(r"(?<=\de[+-])0+(?=\d)|(?<=\de)\+0*(?=\d)")


def _places(values: pd.Series[str], order: Sequence[str]) -> pd.Series[int]:
    """The place of each value in an order.

    Unknown values come last.
    """
    places = {value: place for place, value in enumerate(order)}
    return values.map(places).fillna(len(order)).astype(int)


Rows = TypeVar("Rows")
T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Compared:
    """Attempts by which solvers are compared.

    Cold attempts of engines that could be called, and the time limit of an attempt. `rows` has most
    columns of the schema, and question and scenario (whole numbers) and right (the check accepts
    the answer, and an engine gave it). `methods` is the frame of `methods_of`; `strata` are in the
    order of the experiment's file.
    """

    rows: pd.DataFrame
    methods: pd.DataFrame
    limit_s: float
    strata: tuple[str, ...]

    @cached_property
    def answerable(self) -> pd.DataFrame:
        """The attempts at questions that have a path."""
        return self.rows[self.rows["answerable"]]

    @cached_property
    def engines(self) -> pd.DataFrame:
        """The methods without the closed form."""
        return self.methods[self.methods.index != EXACT]

    def bootstrap(
        self,
        table: pd.DataFrame,
        statistic: Statistic,
        name: str,
        base: str | None = None,
        *,
        of: int = 1,
    ) -> pd.DataFrame:
        """`intervals.bootstrap` over the scenarios of a table.

        The table has questions by solvers. Indexed by solver; columns `name`, `name`_low and
        `name`_high.
        """
        frame = bootstrap(self.by_scenario(table), statistic, base, of=of)
        return frame.set_axis([name, f"{name}_low", f"{name}_high"], axis=1)

    def by_scenario(self, table: pd.DataFrame) -> pd.DataFrame:
        """The table with scenarios in its index.

        Instead of their questions.
        """
        questions = self.rows.drop_duplicates("question").set_index("question")
        return table.set_axis(questions["scenario"].reindex(table.index).to_numpy(), axis=0)


def once(compute: Callable[[Rows], T]) -> Callable[[Rows], T]:
    """The function, computed once for the same rows.

    Nobody may change its result.
    """
    computed: WeakKeyDictionary[Rows, T] = WeakKeyDictionary()

    @wraps(compute)
    def look_up(rows: Rows) -> T:
        if rows not in computed:
            computed[rows] = compute(rows)
        return computed[rows]

    return look_up


# Columns that no comparison reads: every selection of rows would copy them. Tours need three.
_OF_TOURS = {"native_status", "message", "visit_order"}
_UNREAD = [column.name for column in ROW if column.detail and column.name not in _OF_TOURS]


@once
def compared(results: Results) -> Compared | None:
    """Attempts by which solvers are compared, or None.

    Left out: attempts from another solver's path, and those of engines that are not installed.
    """
    rows = results.rows.drop(columns=_UNREAD)
    cold = rows[(rows["initial_guess"] == "cold") & rows["outcome"].ne("unavailable")]
    if cold.empty:
        return None
    methods = methods_of(cold)
    stated = methods[["formulation", "engine", "guess"]]
    cold = cold.assign(
        question=cold.groupby(list(TRIAL), observed=True, sort=False).ngroup(),
        scenario=pd.factorize(cold["scenario_id"])[0],
        right=success(cold),
        presolved=presolved(cold),
        **{str(name): cold["solver"].map(values) for name, values in stated.items()},
    )
    strata = tuple(stratum_order(results, cold["label"].fillna("")))
    return Compared(cold, methods, _limit(cold), strata)


def stratum_order(results: Results, labels: Iterable[str]) -> list[str]:
    """Distinct labels of scenarios, in file order.

    The experiments' files name them in this order.
    """
    text = "\n".join(folder.manifest.experiment.text for folder in results.folders)
    places = {name: text.find(json.dumps(name)) for name in sorted(set(labels))}
    return sorted(places, key=lambda name: (places[name] < 0, places[name]))


def _limit(rows: pd.DataFrame) -> float:
    """The largest time limit of the attempts (s).

    If none is stated, the longest time of an attempt.
    """
    limits = rows["limit_s"][np.isfinite(rows["limit_s"])]
    if limits.empty:
        limits = rows["wall_s"]
    longest = float(limits.max())
    if longest > 0:
        return longest
    return 1.0
