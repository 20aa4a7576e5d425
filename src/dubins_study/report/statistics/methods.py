"""The methods that are compared: names, ranking, attempts."""

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
    """A frame of the methods, one row per solver.

    Solvers are in the order of tables. Rows of attempts that failed may lack a method's columns;
    another row of the solver gives them.

    Returns:
        Indexed by solver, with these columns:

        formulation, engine, guess: as the rows state them. The engine of a plug-in's solver is the
            solver's own name; such solvers come first.
        settings: settings of the spec that distinguish solvers with equal formulation, engine and
            guess; the presolve where it distinguishes solvers of the formulation. With the solver's
            name if it states no engine.
        variant: guess and settings; the guess only where it is unusual or not the only one.
        short: engine and variant, for a figure of one formulation.
        name: engine, guess, settings and formulation, for sentences.
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
    """The shown settings as text: spec -> text.

    `guesses` has each solver's guess; solvers with one formulation, engine and guess are compared.
    """
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
    """A method's name in a sentence.

    An example is `Ipopt (zero) on joint NLP`. The parentheses with the details are left out if
    there are none.
    """
    if details:
        engine += f" ({details})"
    return f"{engine} on {formulation}"


def _joined(*texts: pd.Series[str]) -> pd.Series[str]:
    """Join texts row by row with commas.

    Empty texts are left out: `["Ipopt", "SLSQP"], ["presolve", ""] -> ["Ipopt, presolve",
    "SLSQP"]`.
    """
    lines = zip(*texts, strict=True)
    return pd.Series(
        [", ".join(filter(None, line)) for line in lines], texts[0].index, dtype=object
    )


def best_methods(frame: pd.DataFrame, keys: list[str]) -> pd.DataFrame:
    """The best-supported method of each group.

    The method with the highest lower end of the share's interval is chosen; of several, the
    fastest. So a few questions, all right, support a method less than many questions, nearly all
    right.

    `frame` has a row per method. The columns `keys`, e.g. formulation and engine, define the
    groups; right_low is the lower end (of the share of right answers) and wall_s the median time.
    The chosen rows come back in the order of the frame.
    """
    ranked = _ranked(frame.reset_index(drop=True))
    return frame.iloc[sorted(ranked.drop_duplicates(keys).index)]


def _ranked(frame: pd.DataFrame, low: str = "right_low") -> pd.DataFrame:
    """Sort methods by support: highest lower end, then fastest."""
    return frame.sort_values([low, "wall_s"], ascending=[False, True], kind="stable")


def by_support(rows: pd.DataFrame, keys: list[str]) -> pd.DataFrame:
    """A row per group, the best supported first.

    `rows` are those of `Compared.rows`, and `keys` are the columns that define a group. The columns
    are those of `scenario_shares`, with a question as a trial, and wall_s, the median time (s).
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

    Each engine of a formulation has its best method (`best_methods`). A formulation has at most
    `MOST_ENGINES` engines: those of plug-ins, then the best supported. The closed form is left out,
    since no engine compares to it, unless there is no other.
    """
    engines = frame[frame["formulation"] != FORMULATIONS[0]]
    if engines.empty:
        engines = frame
    best = best_methods(engines, ["formulation", "engine"])
    best = best.assign(place=range(len(best)))  # to restore the order of tables at the end
    ranked = _ranked(best).sort_values(  # plug-ins' solvers first
        "solver", key=lambda solvers: solvers.map(own_name).eq(""), kind="stable"
    )
    drawn = ranked.groupby("formulation", sort=False).head(MOST_ENGINES)
    return drawn.sort_values("place", kind="stable").drop(columns="place")


def foremost(scores: pd.Series[float], most: int = MOST_ENGINES) -> list[str]:
    """The solvers whose curves are drawn in colour.

    They are the plug-ins' solvers, then those with the largest scores, at most `most`. They come
    back in the order of the index. A figure draws the other curves in grey.
    """
    best = scores.sort_values(ascending=False, kind="stable").index
    chosen = list(dict.fromkeys([*own(best), *best]))[:most]
    return [str(name) for name in scores.index if name in chosen]


def _differing_keys(settings: list[dict[str, str]]) -> set[str]:
    """The keys of settings that some specs have otherwise.

    A key counts if two specs give it different values, or if one lacks it.
    """
    keys = set[str]().union(*settings)
    return {key for key in keys if len({group.get(key) for group in settings}) > 1}


def _differing(specs: list[str], *, named: bool, also: set[str]) -> dict[str, str]:
    """The differing settings of each spec: spec -> text.

    The settings `also` are shown even if all specs share them. The solver's name is shown first if
    specs differ in it, or if `named`.
    """
    parsed = [parse_spec(spec) for spec in specs]
    keys = dict.fromkeys(chain.from_iterable(settings for _, settings in parsed))
    differing = _differing_keys([settings for _, settings in parsed]) | also
    shown = [key for key in keys if key in differing]
    # The solver's name is an item too, where it is needed to tell the specs apart.
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

    A switch is shown by its name (`presolve`, `presolve off`), anything else with its value
    (`tol=1e-8`).
    """
    switch = {"true": key, "false": f"{key} off"}
    return switch.get(value.lower(), f"{key}={_ZEROS.sub('', value.lower())}")


# What an exponent can do without: `1e-08` becomes `1e-8`, `1e+03` becomes `1e3`.
_ZEROS = re.compile(r"(?<=\de[+-])0+(?=\d)|(?<=\de)\+0*(?=\d)")


def _places(values: pd.Series[str], order: Sequence[str]) -> pd.Series[int]:
    """The place of each value in an order.

    Unknown values get the place after the last.
    """
    places = {value: place for place, value in enumerate(order)}
    return values.map(places).fillna(len(order)).astype(int)


Rows = TypeVar("Rows")
T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Compared:
    """The attempts by which solvers are compared.

    They are the cold attempts of engines that could be called. `rows` has most columns of the
    schema, and those that `compared` adds: question and scenario (whole numbers), right (the check
    accepts the answer, and an engine gave it), presolved, and the method's formulation, engine and
    guess. `methods` is the frame of `methods_of`. `limit_s` is the time limit of an attempt.
    `strata` are in the order of the experiment's file.
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

        The table has questions by solvers. The result is indexed by solver; its columns are `name`,
        `name`_low and `name`_high. For `base` and `of` see `intervals.bootstrap`.
        """
        frame = bootstrap(self.by_scenario(table), statistic, base, of=of)
        return frame.set_axis([name, f"{name}_low", f"{name}_high"], axis=1)

    def by_scenario(self, table: pd.DataFrame) -> pd.DataFrame:
        """The table with each question replaced by its scenario.

        Only the index changes: questions of one scenario then have the same label.
        """
        questions = self.rows.drop_duplicates("question").set_index("question")
        return table.set_axis(questions["scenario"].reindex(table.index).to_numpy(), axis=0)


def once(compute: Callable[[Rows], T]) -> Callable[[Rows], T]:
    """Wrap a function to compute equal rows once.

    The result is kept as long as the rows object exists. Callers share the result, so nobody may
    change it.
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
    """The attempts by which solvers are compared, or None.

    Left out are attempts that began from another solver's path, and those of engines that are not
    installed. None comes back if no attempt is left.
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
    """The distinct labels in the order of the files.

    A label that no file names comes last.
    """
    # A file names a stratum as a quoted string, which JSON and TOML write alike.
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
