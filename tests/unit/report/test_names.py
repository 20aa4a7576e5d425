"""Short names of solvers.

They are distinct, in natural order, with the spec at hand.
"""

import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dubins_study.report.data.results import load
from dubins_study.report.elements.looks import distinct, figure_names, names_of, short_labels
from dubins_study.report.statistics.methods import methods_of
from dubins_study.report.statistics.metrics import natural
from dubins_study.report.topics.appendix import solvers_section
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import FORMULATIONS
from tests.unit.report.results_folder import attempt

SPECS = st.builds(
    lambda name, settings: (
        name + ("[" + ",".join(f"{k}={v}" for k, v in settings.items()) + "]" if settings else "")
    ),
    st.sampled_from(["ipopt", "nlp", "a #1", "closed form", "Ipopt, joint LRS"]),
    st.dictionaries(st.sampled_from(["n", "presolve", "engine"]), st.text("aT1 \n", max_size=3)),
)
ROWS = st.lists(
    st.tuples(
        SPECS,
        st.sampled_from([None, *FORMULATIONS]),
        st.sampled_from([None, "Ipopt", "closed form", "a #1"]),
        st.sampled_from([None, "none", "zero", "bearing"]),
    ),
    min_size=1,
    max_size=8,
    unique_by=lambda row: row[0],
)


def test_a_warm_question_does_not_make_two_methods_of_one_name(load_rows):
    """A warm question makes no second method.

    It is asked with a path as well as without. The guess is still the method's: a setting differs.
    """
    word = "one NLP a word"
    rows = [
        row("ipopt", word, "Ipopt", "bearing or warm"),
        row("ipopt[units=scenario]", word, "Ipopt", "bearing"),
    ]

    assert names_of(load_rows("warm", rows))["label"].to_dict() == {
        "ipopt": "Ipopt, word NLPs",
        "ipopt[units=scenario]": "Ipopt, word NLPs, units=scenario",
    }


def test_a_long_name_keeps_the_settings_that_come_last(load_rows):
    """A long name keeps its last settings.

    They are those that a study varies; cut at the end, the names would differ in a number.
    """
    spec = "ipopt[model=joint,order=LRS,tol=1e-12,bound_relax=1e-08,mu_target={mu}]"
    specs = [spec.format(mu=mu) for mu in ("1e-11", "1e-10")]
    rows = [row(text, "joint NLP, LRS", "Ipopt", "bearing") for text in specs]
    rows.append(row("ipopt[model=joint,order=LRS]", "joint NLP, LRS", "Ipopt", "bearing"))
    rows.append(row("ipopt[initial_guess=zero]", "joint NLP, LRS", "Ipopt", "zero"))
    labels = names_of(load_rows("long", rows))["label"]

    start = "Ipopt, joint LRS, bearing start, …, "
    assert labels[specs[0]].startswith(start)
    assert [labels[spec].rpartition(", ")[2] for spec in specs] == [
        "mu_target=1e-11",
        "mu_target=1e-10",
    ]


@pytest.mark.slow
@given(ROWS)
def test_no_two_solvers_share_a_name(rows):
    """No two solvers share a name.

    That holds whatever plug-ins call themselves, and whatever their rows do not state.
    """
    frame = pd.DataFrame(rows, columns=["solver", "formulation", "engine", "guess"])
    labels = short_labels(methods_of(frame.astype(object)))

    assert set(labels) == {row[0] for row in rows}
    assert len(set(labels.values())) == len(labels)
    assert not any("\n" in label for label in labels.values())


@given(st.lists(st.sampled_from(["a", "a #1", "a #2", "b"]), max_size=7))
def test_a_number_never_takes_another_solvers_name(labels):
    """A name that is already distinct stays."""
    names = distinct(labels)

    assert len(set(names)) == len(labels)
    for name, label in zip(names, labels, strict=True):
        assert name == label or labels.count(label) > 1


def row(spec, formulation, engine, guess):
    return attempt(
        Scenario(0, 0, 0, 4, 1), spec, formulation=formulation, engine=engine, guess=guess
    )


@pytest.fixture
def folder(results):
    """A folder of five solvers.

    Two of them differ in the guess alone, two in a setting.
    """
    joint = "joint NLP, LRS"
    return results(
        "some",
        [
            row("ipopt[model=joint,order=LRS,initial_guess=zero]", joint, "Ipopt", "zero"),
            row("ipopt[model=joint,order=LRS]", joint, "Ipopt", "bearing"),
            row("turn-rate-qp[n=160]", "turn rates", "PIQP", "bearing"),
            row("turn-rate-qp[n=20]", "turn rates", "PIQP", "bearing"),
            row("slsqp", "one NLP a word", "SLSQP", "bearing"),
        ],
    )


LABELS = {
    "slsqp": "SLSQP, word NLPs",
    "ipopt[model=joint,order=LRS]": "Ipopt, joint LRS, bearing start",
    "ipopt[model=joint,order=LRS,initial_guess=zero]": "Ipopt, joint LRS, zero start",
    "turn-rate-qp[n=20]": "PIQP, turn rates, n=20",
    "turn-rate-qp[n=160]": "PIQP, turn rates, n=160",
}


def test_a_name_says_engine_formulation_guess_and_what_differs(folder):
    """A name has engine, formulation, guess and differences.

    Names come in the order of tables, where 20 steps come before 160.
    """
    labels = names_of(load([folder]))["label"]

    assert labels.to_dict() == LABELS
    assert list(labels) == list(LABELS.values())


def test_natural_order_reads_small_numbers():
    """Tolerances are in powers of ten."""
    texts = ["tol=1e-3", "tol=1e-12", "tol=0.5", "n=10", "n=9", "n"]

    assert sorted(texts, key=natural) == ["n", "n=9", "n=10", "tol=1e-12", "tol=1e-3", "tol=0.5"]


def test_the_settings_table_has_every_solver_and_every_setting(folder):
    """The table has every solver and setting.

    It has what the spec gives, and from the manifest what it leaves at the default.
    """
    results = load([folder])
    section = solvers_section(results)
    frame = section.blocks[0].frame.set_index("solver")
    zero = frame.loc["ipopt[model=joint,order=LRS,initial_guess=zero]"]

    assert frame["label"].to_dict() == LABELS
    assert zero["given"] == "model joint, order LRS, initial_guess zero"
    assert "options equal" in zero["defaults"]
    for spec, settings in results.settings.items():
        listed = f"{frame.loc[spec, 'given']}, {frame.loc[spec, 'defaults']}"
        assert {part.split(" ")[0] for part in listed.split(", ") if part} == set(settings)


def test_a_figure_shows_of_a_name_what_tells_its_solvers_apart():
    """A figure shows only telling parts of names.

    They are engine and formulation; of two that share them, only what the other has not.
    """
    labels = {
        "a": "Ipopt, word NLPs, bearing start",
        "b": "Ipopt, collocation, bearing start, no correct, points=1",
        "c": "Ipopt, collocation, bearing start, no correct, points=2",
        "d": "closed form",
    }

    assert figure_names(labels) == {
        "a": "Ipopt, word NLPs",
        "b": "Ipopt, collocation, points=1",
        "c": "Ipopt, collocation, points=2",
        "d": "closed form",
    }
