"""Experiments: contents, expansion and mistakes of a file."""

import math

import pytest

from dubins_study.experiments.definition.experiment import ExperimentError, packaged, parse, read
from dubins_study.experiments.plan import cells as cells_module
from dubins_study.experiments.plan.cells import chains, shuffled
from dubins_study.experiments.plan.solver_description import expand_solvers
from dubins_study.solvers.registry import SolverError, canonical, load, registered
from dubins_study.study.body_coordinates import local
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.scenario import Scenario

HEAD = 'title = "t"\nquestion = "q"\nsolvers = ["analytic"]\n'
BLOCK = "[[scenarios]]\ntarget_x = 3\ntarget_y = 2\n"


def expand(text: str) -> list[Scenario]:
    groups = chains(parse("name", "name.toml", text).experiment)
    return [cell.scenario for group in groups for cell in group]


@pytest.mark.parametrize("name", packaged())
def test_packaged_experiments_are_valid(name):
    """Packaged experiments are valid.

    Each has a title, a question, and cells with keys of their own.
    """
    experiment = read(name).experiment
    cells = [cell for group in chains(experiment) for cell in group]

    assert experiment.question.endswith("?")
    assert len({cell.key for cell in cells}) == len(cells)


def test_products_and_sweeps():
    """Products and sweeps vary their fields in order.

    The order is the scenario's own, the last one fastest.
    """
    scenarios = expand(
        HEAD + '[[scenarios]]\nheading = ["90deg", 0]\ntarget_x = { linear = [1, 3, 3] }\n'
        "target_y = 2\nradius = { log = [0.1, 10, 3] }\n"
    )

    assert len(scenarios) == 2 * 3 * 3
    assert scenarios[0].heading == pytest.approx(math.pi / 2)
    assert [s.radius for s in scenarios[:3]] == pytest.approx([0.1, 1, 10])
    assert [s.target_x for s in scenarios[::3]] == pytest.approx([1, 2, 3, 1, 2, 3])


WARM = 'title = "t"\nquestion = "q"\nsolvers = ["slsqp"]\ninitial_guesses = ["warm"]\n'


def test_a_sweep_is_known_by_all_its_cells():
    """A sweep is known by all its cells.

    Two sweeps with one cell in common are not one sweep, nor can both own that cell; the same
    sweep twice is one.
    """
    first, second = (BLOCK + f"radius = [{radii}]\n" for radii in ("1, 1.5, 2", "1, 0.5, 0.25"))
    other = second.replace("[[scenarios]]", '[[scenarios]]\nlabel = "down"')

    assert len(expand(WARM + first + first)) == 3
    assert len(expand(WARM + first + other)) == 6
    with pytest.raises(ExperimentError, match=r"scenarios.1, scenario 0: already swept by scen"):
        expand(WARM + first + second)
    with pytest.raises(ExperimentError, match=r"scenarios.0, scenario 2: already swept by itself"):
        expand(WARM + BLOCK + "radius = [1, 2, 1]\n")


def test_polar_targets():
    scenarios = expand(
        HEAD + '[[scenarios]]\nheading = "30deg"\nradius = 2\ndistance = 5\nbearing = "60deg"\n'
    )

    assert (scenarios[0].target_x, scenarios[0].target_y) == pytest.approx((0, 10))


@pytest.mark.parametrize("method", ["sobol", "latin hypercube"])
def test_samples_repeat_and_fill_their_ranges(method):
    text = HEAD + (
        "[[scenarios]]\n[scenarios.sample]\n"
        f'method = "{method}"\ncount = 64\nseed = 5\n'
        "[scenarios.sample.ranges]\ndistance = { log = [0.05, 1000] }\n"
        'bearing = { linear = ["-pi", "pi"] }\n'
    )
    scenarios = expand(text)

    assert scenarios == expand(text)
    assert scenarios != expand(text.replace("seed = 5", "seed = 6"))
    distances = sorted(math.hypot(s.target_x, s.target_y) for s in scenarios)
    assert 0.05 <= distances[0] < 0.1
    assert 500 < distances[-1] <= 1000
    # uniform in the logarithm: the median is the geometric mean of the ends
    assert distances[32] == pytest.approx(math.sqrt(0.05 * 1000), rel=0.3)


@pytest.mark.parametrize("name", ["radius-sweep", "radius-sweep-full"])
def test_the_radius_sweep_crosses_the_circle(name):
    """The radius sweep crosses the circle.

    It has radii on both sides of the radius where the target enters.
    """
    experiment = read(name).experiment
    by_label: dict[str, list[Scenario]] = {}
    for group in chains(experiment.model_copy(update={"solvers": ["analytic"]})):
        for cell in group:
            if cell.solver == "analytic":
                by_label.setdefault(cell.scenario.label, []).append(cell.scenario)

    assert len(by_label) == 5
    for sweep in by_label.values():
        assert len(sweep) >= 20
        inside = [max(local(s).w, local(s).mirrored.w) > 0 for s in sweep]
        assert inside == sorted(inside)
        assert True in inside
        assert False in inside
        assert {len(shortest(s).word) for s in sweep} == {2}


def test_warm_sweeps_are_chains_and_only_for_solvers_that_use_an_initial_guess():
    text = (
        HEAD.replace('["analytic"]', '["analytic", "slsqp"]')
        + 'initial_guesses = ["cold", "warm"]\n'
    )
    groups = chains(parse("n", "n", text + BLOCK + "radius = { log = [0.1, 1, 5] }\n").experiment)

    assert sorted(len(g) for g in groups) == [1] * 10 + [5]
    assert {g[0].solver for g in groups if g[0].initial_guess == "warm"} == {"slsqp"}


def test_order_is_drawn_from_the_seed():
    groups = chains(read("paper").experiment)

    assert shuffled(groups, 1) == shuffled(groups, 1)
    assert shuffled(groups, 1) != shuffled(groups, 2)
    assert sorted(shuffled(groups, 1)) == sorted(groups)


def test_solver_patterns():
    assert expand_solvers(["*", "slsqp"]) == [canonical(name) for name in registered()]
    assert expand_solvers(["slsqp[model={words,joint}]"]) == ["slsqp", "slsqp[model=joint]"]
    assert expand_solvers(["slsqp[ftol={1e-6,1e-9},count={3,4}]"]) == [
        "slsqp[count=3,ftol=1e-06]",
        "slsqp[count=4,ftol=1e-06]",
        "slsqp[count=3,ftol=1e-09]",
        "slsqp[count=4,ftol=1e-09]",
    ]
    with pytest.raises(SolverError, match="no solver named"):
        expand_solvers(["nope"])


def sample(count: int, seed: int) -> str:
    return (
        f'sample = {{ method = "sobol", count = {count}, seed = {seed}, '
        "ranges = { heading = { linear = [0, 1] } } }\n"
    )


def test_sizes_are_counted_exactly():
    """Sizes are counted exactly.

    What is compared with the limit is what would be expanded.
    """
    text = HEAD.replace('["analytic"]', '["analytic", "slsqp"]') + (
        'initial_guesses = ["cold", "warm"]\nrepeats = 2\n'
        + BLOCK
        + "radius = { log = [1, 2, 5] }\n"
    )
    experiment = parse("n", "n", text + "speed = [1, 2]\n" + sample(4, 1)).experiment
    cells = [cell for group in chains(experiment) for cell in group]
    assert len(cells) == 2 * 5 * 2 * 4 * 3
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(cells_module, "MOST_CELLS", len(cells))
        chains(experiment)
        patched.setattr(cells_module, "MOST_CELLS", len(cells) - 1)
        with pytest.raises(ExperimentError, match="240 cells"):
            chains(experiment)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (HEAD, "scenarios: missing"),
        ("scenarios = 3\n" + HEAD, "line 1: scenarios is 3: expected a valid list"),
        (
            HEAD + 'first = { scenarios = 1, solvers = ["slsqp"] }\n' + BLOCK,
            "line 4: first: expected a block with a sample, a route or a tour, without solvers",
        ),
        # a key by the name that it had before has no alias
        (HEAD + BLOCK + "begin = {z1 = 0, z2 = 0, z3 = 1}\n", "scenarios.0.begin: unknown key"),
        (HEAD + "time_limit_s = nan\n" + BLOCK, "time_limit_s is nan"),
        (
            HEAD + BLOCK + "radius = 2026-01-01\n",
            "scenarios.0.radius.0 is datetime.date(2026, 1, 1): expected a valid number",
        ),
        (HEAD + BLOCK + "radius = " + "9" * 5000 + "\n", "not TOML"),
        (HEAD + BLOCK + sample(10**9, 1), "1000000000 cells (a cell for every scenario"),
        (HEAD + "repeats = 1000000000\n" + BLOCK, "1000000000 cells (a cell for every scenario"),
        (
            HEAD + 2 * (BLOCK + "x = { linear = [1, 2, 1500000] }\n"),
            "3000000 cells (a cell for every",
        ),
    ],
)
def test_mistakes_name_file_key_and_value(text, message):
    """More of them are in the folder `mistakes`."""
    with pytest.raises(ExperimentError) as error:
        expand(text)
    assert message in str(error.value)


def test_every_solver_of_given_guesses_is_one_that_takes_them():
    """`*` of given guesses means solvers that take them.

    Others that are named beside a `guess_lengths` are a mistake.
    """
    guesses = "guess_lengths = {z1 = 1, z2 = 0, z3 = [1, 2]}\n"
    scenarios = expand(HEAD.replace("analytic", "*") + BLOCK + guesses)

    assert len(scenarios) == 2 * sum(load(name).warm for name in registered())


def test_what_nobody_is_asked_is_not_expanded():
    """Cells that nobody is asked are not expanded.

    The closed form takes no warm start, so a thousand million repeats of that are no cells.
    """
    assert expand(HEAD + 'initial_guesses = ["warm"]\nrepeats = 1000000000\n' + BLOCK) == []


FIRST = """
title = "t"
question = "?"
solvers = ["analytic"]
first = { scenarios = 2, solvers = ["slsqp"] }
[[scenarios]]
label = "sampled"
sample = { method = "sobol", count = 8, seed = 3, ranges = RANGES }
[[scenarios]]
label = "with solvers of its own"
solvers = ["ipopt"]
sample = { method = "sobol", count = 4, seed = 3, ranges = RANGES }
[[scenarios]]
target_x = 3
target_y = 3
""".replace("RANGES", "{ target_x = { linear = [2, 9] }, target_y = { linear = [2, 9] } }")


def test_slow_solvers_share_the_first_scenarios_with_the_others():
    ids = {}
    for [cell] in chains(parse("t", "t.toml", FIRST).experiment):
        ids.setdefault(cell.solver, []).append(cell.scenario_id)

    assert {name: len(found) for name, found in ids.items()} == {
        "analytic": 9,
        "ipopt": 4,
        "slsqp": 2,
    }
    assert ids["slsqp"] == ids["analytic"][:2]
