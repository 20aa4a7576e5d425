"""The table of formulations by engines.

It has filled cells, reasons, the best guess, and shares by stratum.
"""

import numpy as np
import pandas as pd
import pytest

from dubins_study.report.elements.identity import percent, share_text, with_share
from dubins_study.report.statistics.methods import best_methods, drawn_methods, stratum_order
from dubins_study.report.topics.matrix import matrix, matrix_section
from dubins_study.study.path import Path
from dubins_study.study.rows.manifest import MatrixEntry
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import attempt

WORDS, JOINT = "one NLP a word", "joint NLP, LRS"


def method(formulation, engine, guess="bearing", share=1.0, wall_s=1e-3, of=8):
    """A line of the summary."""
    low = share * of / (of + 4)  # as Wilson's of all right
    spec = f"{engine}[{formulation},{guess}]"
    line = {"formulation": formulation, "engine": engine, "guess": guess, "solver": spec}
    return line | {"right_share": share, "right_of": of, "right_low": low, "wall_s": wall_s}


def entry(formulation, engine, kind="local NLP", reason=None):
    return MatrixEntry(
        formulation=formulation,
        engine=engine,
        kind=kind,
        reason=reason,
        spec=None if reason else "some",
    )


def cell(cells, engine, formulation):
    cells = cells[cells["engine"] == engine]
    (line,) = cells[cells["formulation"] == formulation].to_dict("records")
    return line


def test_the_best_guess_is_the_most_surely_right_then_the_fastest():
    """The best guess is best supported, then fastest.

    Zero is faster and wrong more often; two of two say less than nearly all of many.

    A cell says how few its questions are if nothing else was asked; no sample displaces the whole.
    """
    sample = pd.DataFrame([method(WORDS, "a", "given", 1.0, 1e-4, of=30)])
    frame = pd.DataFrame(
        [
            method(WORDS, "a", "zero", 0.5, 1e-4, of=80),
            method(WORDS, "a", "bearing", 0.9, 2e-3, of=80),
            method(WORDS, "a", "random", 0.9, 1e-3, of=80),
            method(WORDS, "a", "given", 1.0, 1e-4, of=2),
            method(WORDS, "b", "zero", float("nan"), of=80),
            method(JOINT, "a", "zero", 1.0, of=2),
        ]
    )
    cells = matrix(pd.concat([frame, sample], ignore_index=True), [])

    assert best_methods(frame, ["formulation", "engine"])["guess"].tolist() == [
        *("random", "zero", "zero")
    ]
    assert cell(cells, "a", WORDS)["guess"] == "random"
    assert cells.loc[cells["few"], "formulation"].tolist() == [JOINT]


def test_a_panel_has_at_most_ten_engines():
    """A panel has at most ten engines.

    They have the most right answers, in the order of the table, without the closed form.
    """
    lines = [method(WORDS, f"e{n:02}", share=n / 20) for n in range(14)]
    frame = pd.DataFrame([method("closed form", "closed form"), *lines, method(JOINT, "e00")])
    panel = drawn_methods(frame)

    assert panel["engine"].tolist() == [*(f"e{n:02}" for n in range(4, 14)), "e00"]


def labelled(label, place, solver, right, **changes):
    """An attempt in a stratum, right or not."""
    scenario = Scenario(0, 0, 0, 4 + place, 1, label=label)
    path = "exact" if right else Path(scenario.start, [0.0], [0.5])
    claim = Claim.LOCAL if right else Claim.FAILED
    name = {"scenario_id": f"{label}{place}", "engine": solver}
    return attempt(scenario, solver, path=path, claim=claim, **name, **changes)


@pytest.fixture
def benchmark(load_rows):
    """A benchmark's rows, with entries.

    There are two engines in two strata and one that no entry knows.

    The engine b was not to be had where the manifest was written.
    """
    attempts = [labelled("near", n, "a", right=n < 3) for n in range(4)]
    attempts += [labelled("far", n, "a", right=True) for n in range(4)]
    attempts += [labelled(s, n, "b", right=False) for s in ("near", "far") for n in range(4)]
    attempts += [labelled("far", 0, "mine", right=True, formulation=JOINT)]
    attempts += [labelled("far", 0, "closed form", right=True, formulation="closed form")]
    text = 'label = "near"\nlabel = "far"\n'
    experiment = {"name": "e", "text": text, "section": "benchmark"}
    entries = [
        entry("closed form", "closed form", "exact"),
        entry(WORDS, "closed form", "exact", "no engine is needed"),
        *(entry(WORDS, "a"), entry(JOINT, "a", reason="because")),
        *(entry(WORDS, "b", reason="no licence"), entry(JOINT, "b")),
        *(entry(WORDS, "SCIP", "global"), entry(JOINT, "SCIP", "global", "too slow")),
    ]
    dumped = [each.model_dump() for each in entries]
    return load_rows("e", attempts, experiment=experiment, matrix=dumped)


def test_the_section_shows_every_pair_and_every_reason(benchmark):
    """The section shows every pair and every reason.

    The cell has the share; the reason stands below under its number.

    A row counts whatever the manifest says; a pair that could be asked and has no row says so.
    """
    section = matrix_section(benchmark)
    tables = {block.name: block for block in section.blocks if hasattr(block, "columns")}
    (ax,) = section.blocks[0].figure.axes
    engines = [label.get_text() for label in ax.get_yticklabels()]
    names = [label.get_text() for label in ax.get_xticklabels()]
    texts = [text.get_text() for text in ax.texts if not text.get_in_layout()]
    lines = pd.DataFrame(np.reshape(texts, (len(engines), len(names))), engines, names)

    assert engines == ["a", "b", "SCIP", "mine"]
    assert lines.loc["a", WORDS] == "88"
    assert lines.loc["b", WORDS] == "0"
    assert lines.loc["mine", JOINT] == "100*"
    reasons = tables["matrix-reasons"].frame["reason"]
    for engine, formulation, reason in (
        *(("a", JOINT, "because"), ("b", JOINT, "no row"), ("SCIP", WORDS, "no row")),
        ("SCIP", JOINT, "too slow"),
    ):
        number = lines.loc[engine, formulation].strip("[]")
        assert reason in reasons.iloc[int(number) - 1]
    shares = tables["strata"].frame
    assert shares["near"].dropna().tolist() == ["75 %\n30–95", "0 %\n0–49"]
    assert shares.loc[shares["near"].notna(), "far"].tolist() == ["100 %\n51–100", "0 %\n0–49"]
    assert stratum_order(benchmark, ["far", "near"]) == ["near", "far"]


@pytest.mark.parametrize(
    ("share", "expected"), [(0, "0"), (1e-4, "1"), (0.5, "50"), (0.9999, "99"), (1, "100")]
)
def test_whole_percents_say_all_only_of_all(share, expected):
    assert percent(share, 0) == expected


def test_a_share_of_nothing_is_a_dash():
    """A share of nothing is a dash.

    Its interval says that nothing is known.
    """
    frame = with_share(pd.DataFrame({"n": [0]}), "x", pd.Series([0.0]), pd.Series([0]))

    assert frame["x_text"].tolist() == ["–"]
    assert (frame["x_low"].tolist(), frame["x_high"].tolist()) == ([0.0], [1.0])
    assert share_text(2 / 3, 0.2, 0.9, 2 + 2 / 3) == "66.7 % of 2.67,\n20.0 to 90.0 %"
