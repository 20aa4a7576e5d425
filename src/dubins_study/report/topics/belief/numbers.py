"""How true the claims of engines are, and which of their proofs are false."""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.data.command import SCENARIO, number_text, solve_command
from dubins_study.report.statistics.compared import Compared, once
from dubins_study.report.statistics.intervals import scenario_shares

# What a claim is worth, the check being right: it says no more than what is so; it says less than
# the answer allows (no claim of a path that arrives, or of an optimal one only that it is
# feasible); it says nothing and there is nothing; it, or its bound, says more than what is so. A
# bound that is too high by no more than the engine's tolerance explains has a name of its own.
TRUTHS = ("true", "true to its tolerance", "less than known", "says nothing", "false")
TRUE, TOLERATED, LESS, NOTHING, FALSE = TRUTHS
# Two equations that are each off by the tolerance move the length by a small multiple of it.
_TOLERANCES = 10.0
_MOST_CURES = 3
_SILENT = ("failed", "limit", "none")
# Kinds of false proof, the strongest first.
PROOFS = (
    "its bound lies above the shortest length",
    "its bound lies above the shortest length by its tolerance",
    "it calls a path optimal that is longer",
    "it calls a question infeasible that has a path",
    "it calls a path found that does not arrive",
)


def truth(rows: pd.DataFrame) -> pd.Series[str]:
    """The worth of each attempt's claim, one of `TRUTHS`.

    Columns claim, verdict, false_claim, false_bound, tolerance, and those of `excess`. A local
    optimum of another word is no false claim of a local solver.
    """
    claim, verdict = rows["claim"].fillna("none"), rows["verdict"].fillna("none")
    silent = claim.isin(_SILENT)
    arrives = verdict.isin(["optimal", "longer"])
    less = (silent & arrives) | ((claim == "feasible") & (verdict == "optimal"))
    tolerated = excess(rows) <= _TOLERANCES * rows["tolerance"]
    false = _yes(rows["false_claim"]) | (_yes(rows["false_bound"]) & ~tolerated)
    values = np.select(
        [false, _yes(rows["false_bound"]), less, silent], [FALSE, TOLERATED, LESS, NOTHING], TRUE
    )
    return pd.Series(values, rows.index)


def excess(rows: pd.DataFrame) -> pd.Series[float]:
    """By how much each false bound exceeds the shortest length, relative to it; NaN of others.

    A length below the radius counts as the radius.
    """
    scale = np.maximum(rows["reference_high"], rows["radius"])
    above: pd.Series[float] = (rows["lower_bound"] - rows["reference_high"]) / scale
    return above.where(_yes(rows["false_bound"]))


def _yes(values: pd.Series) -> pd.Series[bool]:
    return values.eq(True).fillna(False).astype(bool)


@once
def claims(compared: Compared) -> pd.DataFrame:
    """The attempts whose claim is an engine's: none of the presolve; with `truth` and `proof`.

    `proof` is the kind of a false claim, one of `PROOFS`; missing if the claim is true. `excess` is
    by how much its bound is too high, relative to the shortest length.
    """
    rows = compared.rows[~compared.rows["presolved"]]
    worth = truth(rows)
    claim, verdict = rows["claim"].fillna("none"), rows["verdict"].fillna("none")
    kind = np.select(
        [
            _yes(rows["false_bound"]) & (worth == FALSE),
            worth == TOLERATED,
            (claim == "optimal") & (verdict == "longer"),
            claim == "infeasible",
        ],
        PROOFS[:4],
        PROOFS[4],
    )
    proof = pd.Series(kind, rows.index, dtype=object).where(worth.isin([FALSE, TOLERATED]))
    return rows.assign(truth=worth, proof=proof, excess=excess(rows))


def beliefs(rows: pd.DataFrame, keys: list[str]) -> pd.DataFrame:
    """The shares of each worth, by groups; the unit is the question.

    Args:
        rows: from `claims`.
        keys: columns that name a group.
    Returns:
        Indexed by group. questions; a share for each of `TRUTHS`: the mean over questions of the
        share of its repeats; Wilson's interval of each (`true_low`, ...) for as many trials as
        there are questions; and one count of attempts for each of `PROOFS`.
    """
    parts = []
    for name in TRUTHS:
        hits = rows.assign(hit=rows["truth"] == name)
        shares = scenario_shares(hits, by=keys, success="hit", scenario=["question"])
        titles = {"share": name, "low": f"{name}_low", "high": f"{name}_high"}
        shares = shares.drop(columns="successes").rename(columns={"trials": "questions"} | titles)
        parts.append(shares)
    frame = pd.concat([parts[0], *(part.drop(columns="questions") for part in parts[1:])], axis=1)
    kinds = pd.get_dummies(rows["proof"]).reindex(columns=list(PROOFS), fill_value=False)
    return frame.join(kinds.groupby([rows[key] for key in keys]).sum())


def false_proofs(rows: pd.DataFrame) -> pd.DataFrame:
    """The false claims by solver and kind, each with its plainest example.

    Args:
        rows: from `claims`.
    Returns:
        One row per solver and kind, in the order of `PROOFS`: solver, proof, attempts, questions,
        and of the example: index (of its row), x, y, heading, target_x, target_y, radius, branch,
        lower_bound, length, reference_high, tolerance, command; and most, the largest excess of a
        bound.
    """
    false = rows[rows["proof"].notna()]
    if false.empty:
        return pd.DataFrame(columns=["solver", "proof"])
    order = false.assign(
        digits=_digits(false),
        distance=np.hypot(false["target_x"] - false["x"], false["target_y"] - false["y"])
        / false["radius"],
        place=false["proof"].map({name: place for place, name in enumerate(PROOFS)}),
    ).sort_values(["place", "digits", "distance"], kind="stable")
    groups = order.groupby(["solver", "proof"], sort=False)
    kept = [*SCENARIO, "branch", "lower_bound", "length", "reference_high", "tolerance", "profile"]
    frame = order.drop_duplicates(["solver", "proof"])[["solver", "proof", *kept]]
    counts = groups.agg(attempts=("question", "size"), questions=("question", "nunique"))
    counts["most"] = groups["excess"].max()
    frame = frame.reset_index(names="index").join(counts, on=["solver", "proof"])
    frame["command"] = [solve_command(line) for line in frame.to_dict("records")]
    return frame


def _digits(rows: pd.DataFrame) -> pd.Series[int]:
    """How many characters a scenario's numbers take: few for a round one."""
    sizes = [rows[name].map(lambda value: len(number_text(value))) for name in SCENARIO]
    return pd.concat(sizes, axis=1).sum(axis=1)


def cures(rows: pd.DataFrame, methods: pd.DataFrame) -> pd.DataFrame:
    """For methods with false claims: the same engine otherwise set, without any at the questions.

    A cure has the same engine and formulation, was asked at least one of the questions at which the
    method makes a false claim, and makes none at any question. Without such a cure, the engine's
    other formulations are taken.

    Args:
        rows: from `claims`.
        methods: columns of `methods_of`, by solver.
    Returns:
        One row per method with false claims and cure, at most three (one with an empty `cure` if
        there is none): solver, cure, questions (with a false claim), tried (how many of them the
        cure was asked), right (how many of those it answers correctly in all repeats).
    """
    false = rows[rows["truth"] == FALSE]
    bad = {str(solver): set(group) for solver, group in false.groupby("solver")["question"]}
    right = rows.groupby(["question", "solver"])["right"].all().unstack("solver")
    honest = [solver for solver in methods.index if solver not in bad and solver in right]
    lines = []
    for solver in methods.index.intersection(list(bad)):
        questions = sorted(bad[solver])
        same = [s for s in honest if methods["engine"][s] == methods["engine"][solver]]
        near = [s for s in same if methods["formulation"][s] == methods["formulation"][solver]]
        asked = right.loc[questions, near or same]
        counts = zip(asked.columns, asked.notna().sum(), asked.sum(), strict=True)
        tried = [(s, int(number), int(rights)) for s, number, rights in counts if number]
        # Those that answer the most of the questions come first.
        tried = sorted(tried, key=lambda cure: (-cure[2], -cure[1]))[:_MOST_CURES]
        lines += [(solver, cure, len(questions), *n) for cure, *n in tried or [("", 0, 0)]]
    return pd.DataFrame(lines, columns=["solver", "cure", "questions", "tried", "right"])
