"""The tables and estimates from which findings are computed.

`Evidence` computes each table once. Estimates have their intervals.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
import pandas as pd

from dubins_study.report.data.attempts import ENOUGH_ASKED, EXACT
from dubins_study.report.data.results import Settings
from dubins_study.report.elements.formats import Format, digits, seconds, share, some
from dubins_study.report.elements.identity import with_interval
from dubins_study.report.statistics.intervals import (
    bootstrap_of_both,
    medians,
    wilson_intervals,
)
from dubins_study.report.statistics.methods import Compared
from dubins_study.report.topics.belief import claims
from dubins_study.report.topics.comparison import (
    mean_ranks,
    times,
)
from dubins_study.study.words import SAME_CODE

# Findings need at least this many questions: a bootstrap of fewer scenarios is unreliable.
ENOUGH = 20

_MOST_FLOOR = 0.5  # largest share of the floor in a time that is compared
_TWO = digits(2)  # digits: another process shared the machine that took the times


class Estimate(NamedTuple):
    """A number with its 95 % interval.

    `questions` is the number of questions behind it.
    """

    value: float
    low: float
    high: float
    questions: int

    def text(self, show: Format = _TWO) -> str:
        """The number and its interval: `2.5 (2.1 to 3.4)`."""
        return with_interval(show, self.value, self.low, self.high)

    def is_clear(self, none: float = 0.0) -> bool:
        """Whether the interval excludes `none`: no difference.

        For a difference `none` is 0, for a ratio 1.
        """
        return not self.low <= none <= self.high

    def turned(self) -> Estimate:
        """The same difference with the opposite sign.

        It says how much better the second of a pair is, instead of the first.
        """
        return Estimate(-self.value, -self.high, -self.low, self.questions)

    def percent_text(self) -> str:
        """A share in per cent with its interval.

        An example is `25.0 % (21.0 to 34.2)`.
        """
        return self.text(share)


class Finding(NamedTuple):
    """A sentence that a practitioner can act on.

    The sentence has one number with its interval, the `estimate`. `question` is a text on where the
    number comes from: the numbers of questions and methods, and further facts of the rows.
    `shown_in` names the section, and the table or figure, that shows it.
    """

    sentence: str
    estimate: Estimate
    question: str
    shown_in: str


def estimate_of(intervals: pd.DataFrame, questions: int) -> Estimate:
    """The estimate in the first row of a frame.

    The frame has three columns: the number, and the two ends of its interval.
    """
    value, low, high = intervals.iloc[0].tolist()
    return Estimate(value, low, high, questions)


def chosen_share(share: float, questions: int, of: int) -> Estimate:
    """The estimate of a share, chosen as most extreme.

    It was chosen among `of` shares of questions; all their intervals hold at once.
    """
    low, high = wilson_intervals(min(share * questions, questions), questions, of)
    return Estimate(share, low, high, questions)


Pair = tuple[str, str]


class Evidence:
    """Tables of engines' attempts where a path exists.

    Args:
        compared: the attempts.
        of: number of findings whose intervals all hold at once.
        settings: all settings of each solver, also those left out of its spec.
    """

    def __init__(self, compared: Compared, of: int = 1, settings: Settings | None = None) -> None:
        self.compared = compared
        self.of = of
        self.settings = settings or {}
        rows = compared.rows.groupby("solver", observed=True)
        self.methods = compared.engines.join(rows[["guesses", "presolve", "knows"]].first())

    @cached_property
    def rates(self) -> pd.DataFrame:
        """The share of right repeats, questions by solvers.

        NaN where the solver was not asked.
        """
        rows = self.compared.answerable
        right = rows["right"].astype(float)
        return right.groupby([rows["question"], rows["solver"]]).mean().unstack()

    @cached_property
    def ranked(self) -> pd.DataFrame:
        """The methods ordered by their mean times, perhaps none.

        A failure counts as the limit in a mean.
        """
        return mean_ranks(self.compared).methods

    @cached_property
    def claims(self) -> pd.DataFrame:
        """The engines' attempts with the worth of their claims.

        Attempts at questions without a path are included.
        """
        rows = claims(self.compared)
        return rows[rows["solver"] != EXACT]

    @cached_property
    def provers(self) -> list[str]:
        """Solvers that claim optimality or give a bound.

        They are in the order of tables.
        """
        proof = self.claims["claim"].eq("optimal") | self.claims["lower_bound"].notna()
        proves = self.methods.index.isin(self.claims.loc[proof, "solver"])
        return self.methods.index[proves].tolist()

    def name(self, solver: str) -> str:
        """A method's name in a sentence.

        It has the engine, the guess, the settings and the formulation.
        """
        return str(self.methods["name"][solver])

    def knows(self, solver: str) -> str:
        """What a method is told besides the question.

        The words are those of the column `knows`; empty if nothing.
        """
        return str(self.methods["knows"].fillna("")[solver])

    @cached_property
    def usual(self) -> pd.DataFrame:
        """The methods that met nearly all questions.

        A comparison with other methods would compare the questions.
        """
        return self.met_most(self.compared.answerable)

    def met_most(self, rows: pd.DataFrame) -> pd.DataFrame:
        """The methods that met nearly all these questions.

        Nearly all is a share of at least `ENOUGH_ASKED`.
        """
        questions_met = rows.groupby("solver", observed=True)["question"].nunique()
        share = questions_met.reindex(self.methods.index).fillna(0.0) / max(
            rows["question"].nunique(), 1
        )
        return self.methods[share >= ENOUGH_ASKED]

    @cached_property
    def at_floor(self) -> list[str]:
        """The solvers whose time is mostly the floor.

        The floor counts as often as the engine was called. It is more than half of these solvers'
        median times, so no sentence compares their times.
        """
        rows = self.compared.answerable
        runs = rows["subproblem_runs"].map(np.sum, na_action="ignore").astype(np.float64)
        part = rows["floor_s"].astype(np.float64) * runs.fillna(1.0) / rows["wall_s"]
        parts = part.groupby(rows["solver"]).median()
        return parts.index[parts > _MOST_FLOOR].tolist()

    def pairs(self, same: list[str], differs: str, value: str, other: str) -> list[Pair]:
        """Pairs of solvers that differ in one column.

        The first solver has `value` in the column `differs`, the second has `other`. Both agree in
        the columns `same`. If several solvers fit, the first in the order of tables is taken.
        """
        kinds = self.usual.dropna(subset=same).reset_index().drop_duplicates([*same, differs])
        first = kinds[kinds[differs] == value]
        second = kinds[kinds[differs] == other]
        both = first.merge(second, on=same)  # solver_x has `value`, solver_y has `other`
        return list(zip(both["solver_x"], both["solver_y"], strict=True))

    def median(self, values: pd.Series[float]) -> Estimate | None:
        """The median of values over questions.

        None if fewer than `ENOUGH` questions have a value.
        """
        known = values.dropna().to_frame("value")
        if len(known) < ENOUGH:
            return None
        return estimate_of(self.compared.bootstrap(known, medians, "value", of=self.of), len(known))

    def estimate_over_engines(self, table: pd.DataFrame, of: int = 1) -> Estimate | None:
        """The mean of a table of questions by solvers.

        Its interval is over scenarios and engines, where engines that share their code count as
        one. The interval is widened until it holds the mean without any one engine. If the mean is
        one of `of` means, all their intervals hold at once. None if fewer than `ENOUGH` questions
        have a value.
        """
        known = table.dropna(how="all")
        if len(known) < ENOUGH:
            return None
        engines = self.methods["engine"].reindex(table.columns)
        codes = engines.map(SAME_CODE).fillna(engines)
        frame = bootstrap_of_both(self.compared.by_scenario(known), codes.tolist(), of * self.of)
        whole = estimate_of(frame, len(known))
        without = [known.loc[:, (codes != code).to_numpy()] for code in codes.unique()]
        means = [np.nanmean(part) for part in without if part.notna().any(axis=None)]
        low = min([whole.low, *means])
        high = max([whole.high, *means])
        return whole._replace(low=float(low), high=float(high))

    def share_of(self, rates: pd.Series[float]) -> Estimate | None:
        """The mean of rates over questions, with Wilson's interval.

        Each question is a trial. None if there are fewer than `ENOUGH`.
        """
        known = rates.dropna()
        if len(known) < ENOUGH:
            return None
        return chosen_share(float(known.mean()), len(known), self.of)

    def time_ratio(self, solver: str, base: str) -> Estimate | None:
        """The ratio of two solvers' times, solver / base.

        The times are medians over the questions on which both are right. A question counts by the
        median over its repeats. None if there are fewer than `ENOUGH` questions, or if one of the
        times is mostly the floor.
        """
        timed = set(times(self.compared).columns) - set(self.at_floor)
        if not {solver, base} <= timed:
            return None
        both = self._both_right(solver, base)
        if len(both) < ENOUGH:
            return None
        ratios = self.compared.bootstrap(both, medians, "value", base, of=self.of)
        return estimate_of(ratios.loc[[solver]], len(both))

    def medians_of(self, solver: str, base: str) -> str:
        """A text with the two medians that `time_ratio` divides.

        An example is `31 questions that both answer, medians 2.1 s and 40 ms`.
        """
        both = self._both_right(solver, base)
        medians_text = " and ".join(map(seconds, both.median()))
        return f"{some(len(both), 'question')} that both answer, medians {medians_text}"

    def _both_right(self, solver: str, base: str) -> pd.DataFrame:
        """The times (s) at questions that both solve."""
        return times(self.compared)[[solver, base]].replace(np.inf, np.nan).dropna()
