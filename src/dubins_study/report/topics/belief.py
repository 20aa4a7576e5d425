"""What engines claim, and which claims are false."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from dubins_study.report.data.attempts import (
    EXACT,
    first_true,
    is_true,
    own,
)
from dubins_study.report.data.command import ROUTE, SCENARIO
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns
from dubins_study.report.elements.content import (
    Block,
    General,
    Picture,
    Place,
    Section,
    Table,
    Topic,
    panels_picture,
)
from dubins_study.report.elements.formats import count, digits, sentences, some
from dubins_study.report.elements.plots import Mark, stacked_shares
from dubins_study.report.elements.style import BLUE, ORANGE, RULE, VERMILION
from dubins_study.report.statistics.methods import Compared, compared, once
from dubins_study.report.topics.failures import plainest
from dubins_study.study.scenario_frame import solve_command
from dubins_study.study.words import Claim, Outcome

# The worth of a claim, compared with the check's verdict. True: it says no more than the verdict.
# True to its tolerance: its bound is too high by no more than the engine's tolerance explains.
# Better than claimed: a path arrives without a claim, or a shortest path is called feasible only.
# Says nothing: no claim, and no path that arrives. Denial: a local engine found no path near its
# last point where a path exists, which is no claim about the question. False: the claim, or its
# bound, says more than the verdict.
TRUTHS = ("true", "true to its tolerance", "better than claimed", "says nothing", "denial", "false")
TRUE, TOLERATED, LESS, NOTHING, DENIAL, FALSE = TRUTHS
# Two equations that are each off by the tolerance move the length by a small multiple of it.
_TOLERANCES = 10.0
_SILENT = ("failed", "limit", "none")
# From dark to light with hatches, so that grey print keeps them apart.
MARKS = (
    Mark(TRUE, colour=BLUE),
    Mark(TOLERATED, colour="#3f8fc4", hatch="||"),
    Mark(LESS, colour="#86bce0", hatch="///"),
    Mark(NOTHING, colour=RULE),
    Mark(DENIAL, colour=ORANGE, hatch=".."),
    Mark(FALSE, colour=VERMILION, hatch="xx"),
)
# Fewer than this share of the questions that others met is worth a note.
FEW = 0.5
# Kinds of false proof, the strongest first, and their names in a table's head.
_SHORT = {
    "its bound lies above the shortest length": "a bound that is too high",
    "its bound lies above the shortest length by its tolerance": "a bound high by its tolerance",
    "it calls a path optimal that is longer": "a longer path called optimal",
    "it calls a question infeasible that has a path": "no path, though one exists",
    "it calls a path found that does not arrive": "a path that misses",
}
PROOFS = tuple(_SHORT)


@once
def claims(compared: Compared) -> pd.DataFrame:
    """Engines' attempts with the worth of each claim.

    Attempts that the presolve answered are left out. Three columns are added. `truth` is one of
    `TRUTHS`; a local optimum of another word is no false claim of a local solver. `proof` is the
    kind of a false claim, or of one that is false only within the tolerance: one of `PROOFS`. It is
    missing for all other claims. `excess` is by how much a bound is too high, relative to the
    shortest length or, if that is larger, to the radius.
    """
    rows = compared.rows[~compared.rows["presolved"]]
    claim = rows["claim"].fillna("none")
    verdict = rows["verdict"].fillna("none")
    high = is_true(rows["false_bound"])
    scale = np.maximum(rows["reference_high"], rows["radius"])
    above: pd.Series[float] = (rows["lower_bound"] - rows["reference_high"]) / scale
    excess = above.where(high)
    # Without a known tolerance nothing is explained: a comparison with NaN does not hold.
    explained = excess <= _TOLERANCES * rows["tolerance"]
    false = is_true(rows["false_claim"]) | (high & ~explained)
    silent = claim.isin(_SILENT)
    less = silent & verdict.isin(["optimal", "longer"])
    less |= (claim == "feasible") & (verdict == "optimal")
    denial = rows["answerable"] & (claim == Claim.LOCALLY_INFEASIBLE)
    worths = {
        FALSE: false,
        TOLERATED: high,
        DENIAL: denial,
        LESS: less,
        NOTHING: silent,
    }
    truth = first_true(worths, TRUE)
    kinds = [  # in the order of PROOFS; its last one if none holds
        high & false,
        high,
        (claim == "optimal") & (verdict == "longer"),
        claim == "infeasible",
    ]
    proof = pd.Series(np.select(kinds, PROOFS[:4], PROOFS[4]), rows.index, dtype=object)
    return rows.assign(truth=truth, proof=proof.where(false | high), excess=excess)


def beliefs(rows: pd.DataFrame) -> pd.DataFrame:
    """The shares of `TRUTHS` among each solver's claims.

    `rows` are those of `claims`. The result has one row per solver, with its number of questions. A
    share is the mean over questions of the share of a question's repeats.
    """
    worths = pd.get_dummies(rows["truth"]).reindex(columns=list(TRUTHS), fill_value=False)
    by_question = worths.groupby([rows["solver"], rows["question"]]).mean()
    groups = by_question.groupby("solver")
    return groups.mean().assign(questions=groups.size())


def false_proofs(rows: pd.DataFrame) -> pd.DataFrame:
    """False claims by solver and kind, with examples.

    `rows` are those of `claims`. Rows are in the order of `PROOFS`. Columns: solver, proof,
    attempts, questions, most (the largest excess of a bound). Of the plainest example there are the
    scenario, lengths, tolerance and the command that asks it again.
    """
    false = rows[rows["proof"].notna()]
    order = plainest(false, ["solver", "proof"])
    order = order.sort_values("proof", key=lambda proof: proof.map(PROOFS.index), kind="stable")
    groups = false.groupby(["solver", "proof"])
    shown = [*SCENARIO, *(name for name in ROUTE if name in order), "branch", "profile"]
    shown += ["lower_bound", "length", "reference_high", "tolerance"]
    frame = order[["solver", "proof", *shown]]
    counts = groups.agg(attempts=("question", "size"), questions=("question", "nunique"))
    counts["most"] = groups["excess"].max()
    frame = frame.join(counts, on=["solver", "proof"])
    frame["command"] = [solve_command(line) for line in frame.to_dict("records")]
    return frame


_MOST_BARS = 3  # in a panel
_MOST_EXAMPLES = 40


def belief_section(results: Results) -> Section | None:
    """The section on what claims are worth."""
    attempts = compared(results)
    if attempts is None:
        return None
    rows = claims(attempts)
    if rows.empty:
        return None
    names = attempts.methods
    table = names.join(beliefs(rows), how="inner")
    table["false_claims"] = rows[rows["truth"] == FALSE].groupby("solver").size()
    table["false_claims"] = table["false_claims"].fillna(0)
    sizes = rows.groupby("experiment")["question"].nunique()
    suites = rows.drop_duplicates(["solver", "experiment"])
    # questions of all suites that ask the method: so many it could have met
    table["askable"] = suites["experiment"].map(sizes).groupby(suites["solver"]).sum()
    false = false_proofs(rows)
    blocks: list[Block] = [_picture(table)]
    if len(false):
        blocks.append(_proof_table(false, names))
    text = sentences(
        "A claim is what a solver says of its answer. It is true if the check confirms it.",
        "Local engines claim only that no path nearby is shorter, which can be true of a longer "
        "path.",
        _liars(rows, table),
    )
    lead = (
        "Crossed, and counted beside the bar: answers that claim more than is true. Dotted: "
        "denials by local engines."
    )
    return Section("belief", "Whom one can believe", text, tuple(blocks), lead)


def _liars(rows: pd.DataFrame, table: pd.DataFrame) -> str:
    """Sentences that count false claims and denials.

    `rows` are those of `claims`; `table` has a row per method. False claims are counted by kind. It
    also says how many claims of an optimum are false.
    """
    attempts_made = int((rows["outcome"] != Outcome.NOT_ASKED).sum())
    false = rows.loc[rows["truth"] == FALSE, "proof"]
    claimed = some(len(false), "false claim")
    kinds = [f"{_SHORT[str(kind)]}: {count(n)}" for kind, n in false.value_counts().items()]
    listed = ""
    if kinds:
        listed = f" ({', '.join(kinds)})"
    number = some(int((table["false_claims"] > 0).sum()), "method")
    denials = int((rows["truth"] == DENIAL).sum())
    optima = rows[(rows["claim"] == Claim.OPTIMAL) & (rows["solver"] != EXACT)]
    wrong = int((is_true(optima["false_claim"]) & optima["verdict"].eq("longer")).sum())
    attempts = f"{some(attempts_made, 'attempt')} at legs and routes"
    liars = f"No method makes a false claim in {attempts}."
    if len(false):
        liars = f"In {attempts} {number} of {count(len(table))} made {claimed}{listed}."
    parts = [liars]
    by_makers = int(rows.loc[false.index, "tolerance"].isna().sum())
    if by_makers:
        parts.append(f"{count(by_makers)} of them are at the options of the engine's makers.")
    if denials:
        parts.append(
            f"{some(denials, 'denial')} are counted apart: a local engine reports that no path is "
            "near its last point, though a path exists."
        )
    if len(optima):
        claims_of_optima = some(len(optima), "claim")
        parts.append(
            f"Of {claims_of_optima} of engines that a path is optimal {count(wrong)} are false."
        )
    return sentences(*parts)


def _picture(table: pd.DataFrame) -> Picture:
    """The bars of claims, at most `_MOST_BARS` per formulation.

    The methods with the most false claims are drawn, and all of plug-ins.
    """
    plugins = own(table.index)  # shown besides the chosen methods
    engines = table[~table.index.isin([EXACT, *plugins])].sort_values(
        [FALSE, DENIAL], ascending=False
    )
    candidates = engines
    if engines.empty:
        candidates = table
    shown = candidates.groupby("formulation", sort=False).head(_MOST_BARS)
    left_out = len(engines) - len(shown)
    shown = table[table.index.isin([*plugins, *shown.index])]
    rest = ""
    if left_out > 0:
        rest = (
            f" At most {_MOST_BARS} methods a formulation, those with most false claims, then "
            f"denials; {count(left_out)} are left out."
        )
    few = shown["questions"] < FEW * shown["askable"]
    star = ""
    if few.any():
        star = " †: asked a sample only."
    caption = (
        "Bold: formulations; below each its engines, with guess and options. Shares of the "
        f"questions, those without a path included.{rest}{star} A narrow screen shows only methods "
        "with false claims."
    )
    alt = "Stacked bars of true, weak, silent and false claims, by formulation"
    notes = []
    for false_count, is_few in zip(shown["false_claims"], few, strict=True):
        note = ""
        if false_count:
            note = count(false_count)
        if is_few:
            note += "†"
        notes.append(note)
    return panels_picture("belief-claims", caption, _bars, alt, shown.assign(note=notes))


def _bars(shown: pd.DataFrame, *, narrow: bool) -> Figure:
    """Draw the bars of methods' claims.

    A `narrow` figure shows only methods with false claims, and plug-ins', if there are any.
    """
    in_narrow = (shown["false_claims"] > 0) | shown.index.isin(own(shown.index))
    bars = shown
    if narrow and in_narrow.any():
        bars = shown[in_narrow]
    return stacked_shares(bars, MARKS, "share of questions", narrow=narrow)


def _proof_table(false: pd.DataFrame, names: pd.DataFrame) -> Table:
    """The table of false claims, with examples."""
    frame = names.reindex(false["solver"]).reset_index(drop=True)
    frame = frame.join(false.reset_index(drop=True)).head(_MOST_EXAMPLES)
    frame["kind_of_proof"] = frame["proof"].map(_SHORT)
    shown = (
        *columns(kind="text", name="method", kind_of_proof="what is false"),
        *columns(count, attempts="attempts", questions="questions"),
        *columns(
            digits(9), lower_bound="its bound", length="its length", reference_high="shortest"
        ),
        *columns(digits(2), most="bound too high by, at most", tolerance="tolerance"),
        *columns(kind="command", command="ask again"),
    )
    caption = (
        "Kinds of false claims, each with the example of the nearest target; the command repeats "
        "it. A bound too high by at most ten times the feasibility asked for counts as true to its "
        "tolerance. Lengths in the scenario's unit."
    )
    return Table("belief-false", caption, frame, shown, dense=True)


def proof_section(results: Results) -> Section | None:
    """The section on engines that claim proofs.

    The engines are asked with models and settings that are known to fail. It is `belief_section`
    with other names.
    """
    section = belief_section(results)
    if section is None:
        return None
    return replace(
        section,
        key="claims-of-proof",
        title="Claims of proof where they are known to fail",
        lead="Examples of models, settings and targets at which a proof is known to fail; no rate.",
        blocks=tuple(replace(block, name=f"{block.name}-of-proof") for block in section.blocks),
    )


TOPIC = Topic("whom one can believe", belief_section, General.BENCHMARKED, place=Place.FRONT)
OF_PROOF = Topic("claims of proof", proof_section, "claims")
