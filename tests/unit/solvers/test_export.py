"""Exported models are read back and solved.

They are also evaluated at the closed form's solutions.
"""

import math
import re

import casadi
import numpy as np
import pyscipopt
import pytest

from dubins_study.solvers.export import FORMATS, ORDERS, ExportError, export
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.scenario import Scenario
from tests.cases import EDGES, PAPER

# every region, another unit of length, a start elsewhere, negative coordinates
CASES = {
    **{name: PAPER[name] for name in ("problem 1", "problem 3", "problem 4", "problem 5, R=25")},
    **{name: EDGES[name] for name in ("behind", "off centre in the left disc", "beside")},
    "right disc, R=3": Scenario(-5, 2, -2.5, -6, 4.5, 3),
}
# the words that lie in each order, and which of z1, z2, z3 their segments are
PLACES = {
    "LRS": {"LS": (0, 2), "RS": (1, 2), "LR": (0, 1)},
    "RLS": {"RS": (0, 2), "LS": (1, 2), "RL": (0, 1)},
}
KINDS = [("paper", f, o) for f in FORMATS["paper"] for o in ORDERS["paper"]]
KINDS += [("disjunctive", f, "LRS") for f in ("nl", "gams")]


def read_nl(text, folder):
    file = folder / "model.nl"
    file.write_text(text)
    builder = casadi.NlpBuilder()
    builder.import_nl(str(file))
    return builder


def names_in(text):
    """Names of the variables, in order.

    They stand in the first line of an NL file.
    """
    return text.partition("\n")[0].partition("variables ")[2].split()


def paper_points(scenario, order):
    """Closed-form paths of an order's words.

    They are given as (z1, z2, z3).
    """
    for word, places in PLACES[order].items():
        optimum = shortest(scenario, word)
        if optimum is not None:
            z = np.zeros(3)
            z[list(places)] = optimum.segments
            yield z * scenario.radius


def evaluate(expression, values):
    """Value of an AMPL or GAMS expression.

    It has +, -, *, /, sin and cos.
    """
    assert re.fullmatch(r"[\w\s.+*/()-]+", expression), expression
    return eval(expression.strip(), {"sin": math.sin, "cos": math.cos}, dict(values))


def mod_residuals(text, z):
    """Constraints' left sides of a .mod file.

    They are evaluated at (z1, z2, z3), and so is its objective.

    A small reader of its own: comments off, statements split at semicolons, in their order.
    """
    values = dict(zip(("z1", "z2", "z3"), z, strict=True))
    residuals = {}
    objective = None
    for statement in re.sub(r"#.*", "", text).split(";"):
        words = statement.split(maxsplit=2)
        if not words:
            continue
        if words[0] == "param":
            values[words[1]] = evaluate(words[2].removeprefix(":="), values)
        elif words[0] == "var" and words[2].startswith("="):
            values[words[1]] = evaluate(words[2].removeprefix("="), values)
        elif words[0] == "var":
            assert re.fullmatch(r">= 0, := [\d.e+-]+", words[2])
        elif words[0] == "minimize":
            objective = evaluate(words[2], values)
        else:
            assert words[:2] == ["subject", "to"]
            name, _, body = words[2].partition(":")
            left, _, right = body.rpartition("=")
            residuals[name] = evaluate(left, values) - evaluate(right, values)
    return residuals, objective


def gams_equations(text):
    """Every equation in a GAMS file.

    It is (name, left, relation, right).
    """
    return re.findall(r"^(\w+)\.\. (.*) (=[el]=) (.*) ;$", text, re.MULTILINE)


@pytest.mark.parametrize("order", ORDERS["paper"])
@pytest.mark.parametrize("name", CASES)
def test_the_closed_form_solves_the_papers_model_in_every_format(name, order, tmp_path):
    """The closed form solves the model in every format.

    It is the paper's model. Every word of an order is a feasible point, and its length the
    objective, in each file.

    Coordinates of up to 85 units and sums of a few terms leave 1e-13 units at most.
    """
    scenario = CASES[name]
    nl = read_nl(export(scenario, "paper", "nl", order), tmp_path)
    rows = casadi.Function("rows", [casadi.vertcat(*nl.x)], [casadi.vertcat(*nl.g), nl.f])
    mod = export(scenario, "paper", "mod", order)
    gams = gams_equations(export(scenario, "paper", "gams", order))
    assert [equation[0] for equation in gams] == ["x_end", "y_end", "f"]
    assert (nl.x_lb, nl.x_ub, nl.discrete) == ([0.0] * 3, [math.inf] * 3, [False] * 3)
    points = list(paper_points(scenario, order))
    assert points

    for z in points:
        g, f = (value.full().ravel() for value in rows(z))
        np.testing.assert_allclose(g, nl.g_lb, atol=1e-12)
        assert nl.g_lb == nl.g_ub
        assert f == pytest.approx(z.sum())
        residuals, objective = mod_residuals(mod, z)
        assert residuals == pytest.approx({"x_end": 0, "y_end": 0}, abs=1e-12)
        assert objective == pytest.approx(z.sum())
        values = dict(zip(("z1", "z2", "z3"), z, strict=True)) | {"GAMS_OBJECTIVE": z.sum()}
        for _, left, relation, right in gams:
            assert relation == "=e="
            assert evaluate(left, values) == pytest.approx(evaluate(right, values), abs=1e-12)
    # where a wrong sign or factor would show: at points that are no solution
    for z in np.random.default_rng(0).uniform(0, 12, (3, 3)):
        residuals, _ = mod_residuals(mod, z)
        values = dict(zip(("z1", "z2", "z3"), z, strict=True))
        of_gams = [evaluate(left, values) for _, left, _, _ in gams[:2]]
        assert list(residuals.values()) == pytest.approx(of_gams, abs=1e-12)
        assert rows(z)[0].full().ravel() - nl.g_lb == pytest.approx(of_gams, abs=1e-12)


def test_the_starting_point_of_every_format_is_the_same(tmp_path):
    """Every format has the same starting point.

    It is not AMPL's zero, unless the target's direction says so.
    """
    scenario = CASES["right disc, R=3"]

    nl = read_nl(export(scenario, "paper", "nl"), tmp_path).x_init
    mod = re.findall(r"^var z\d >= 0, := (\S+);", export(scenario, format="mod"), re.MULTILINE)
    gams = re.findall(r"^z\d\.l = (\S+);", export(scenario, format="gams"), re.MULTILINE)

    assert [float(value) for value in mod] == nl == pytest.approx([float(v) for v in gams])
    assert any(nl)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["problem 1", "off centre in the left disc", "at the start"])
def test_the_disjunctive_nl_file_is_solved_to_the_shortest_length(name, tmp_path):
    """SCIP solves the disjunctive NL file.

    The length is the shortest. SCIP has its own reader and its own proof; it meets each equation
    to 1e-6 and gains by a few.
    """
    scenario = CASES.get(name) or EDGES[name]
    file = tmp_path / "model.nl"
    file.write_text(export(scenario, "disjunctive", "nl"))
    scip = pyscipopt.Model()
    scip.hideOutput()
    scip.readProblem(str(file))

    scip.optimize()

    assert scip.getStatus() == "optimal"
    assert scip.getObjVal() == pytest.approx(shortest(scenario).total, abs=5e-5)


@pytest.mark.parametrize("name", CASES)
def test_the_closed_form_solves_the_disjunctive_model(name, tmp_path):
    """The closed form solves the disjunctive model.

    The shortest path satisfies every row of both files, its word's binary being 1.
    """
    scenario = CASES[name]
    optimum = shortest(scenario)
    first, second = optimum.segments
    straight = optimum.word[1] == "S"
    values = {"w[0]": second if straight else 0.0}
    for name, arc in {"alpha": first, "gamma": 0.0 if straight else second}.items():
        angle = f"0,{name}"
        quarter = math.pi / 2
        quadrant = min(int(arc / quarter), 3)
        q = values[f"q[{angle}]"] = arc - quadrant * quarter
        values |= {f"z[{angle}]": arc, f"c[{angle}]": math.cos(arc), f"s[{angle}]": math.sin(arc)}
        values |= {f"cos_q[{angle}]": math.cos(q), f"sin_q[{angle}]": math.sin(q)}
        values |= {f"quadrant[{angle},{k}]": float(k == quadrant) for k in range(4)}
    values |= {f"word[0,{word}]": float(word == optimum.word) for word in ("LS", "RS", "LR", "RL")}
    text = export(scenario, "disjunctive", "nl")
    assert set(names_in(text)) == set(values)

    nl = read_nl(text, tmp_path)
    point = np.array([values[name] for name in names_in(text)])
    rows = casadi.Function("rows", [casadi.vertcat(*nl.x)], [casadi.vertcat(*nl.g), nl.f])
    g, f = (value.full().ravel() for value in rows(point))

    assert (g >= np.array(nl.g_lb) - 1e-12).all()
    assert (g <= np.array(nl.g_ub) + 1e-12).all()
    assert (point >= np.array(nl.x_lb) - 1e-12).all()
    assert (point <= np.array(nl.x_ub) + 1e-12).all()
    assert f == pytest.approx(optimum.total)
    assert sum(nl.discrete) == 4 + 2 * 4

    in_gams = {re.sub(r"\W", "_", name): value for name, value in values.items()}
    binary = re.compile(r"^(word_0_.._|quadrant_0_\w+_._)$")
    in_gams = {binary.sub(r"\1_binary_indicator_var", n): in_gams[n] for n in in_gams}
    equations = gams_equations(export(scenario, "disjunctive", "gams"))
    assert len(equations) == len(g) + 1
    for _, left, relation, right in equations:
        difference = evaluate(left, in_gams | {"GAMS_OBJECTIVE": optimum.total}) - evaluate(
            right, in_gams | {"GAMS_OBJECTIVE": optimum.total}
        )
        assert difference <= 1e-12
        assert relation == "=l=" or difference >= -1e-12


def test_a_label_stays_out_of_the_file():
    """A label stays out of the file.

    A label is any text, with line ends too; a file is a program.
    """
    labelled = Scenario(0, 0, 0, 1, 2, 1, label="x\n; shell 'ls';")

    for model, format, order in KINDS:
        plain = export(Scenario(0, 0, 0, 1, 2, 1), model, format, order)
        assert export(labelled, model, format, order) == plain


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"model": "papers"}, "model is 'papers'; did you mean 'paper'? expected one of: paper"),
        ({"format": "lp"}, "format is 'lp'; expected one of: nl, mod, gams"),
        ({"order": "both"}, "order is 'both'; expected one of: LRS, RLS"),
        ({"model": "disjunctive", "format": "mod"}, "expected one of: nl, gams"),
        (
            {"model": "disjunctive", "order": "RLS"},
            "order is 'RLS'; did you mean 'LRS'? expected one of: LRS",
        ),
    ],
)
def test_what_cannot_be_written_is_refused(arguments, message):
    with pytest.raises(ExportError, match=re.escape(message)):
        export(CASES["problem 1"], **arguments)
