"""Programs as files in AMPL's format NL.

Any engine with an AMPL interface reads this format.
"""

from __future__ import annotations

from io import StringIO
from typing import Any, NamedTuple

from dubins_study.solvers.minlp_engines.mixed_program import MixedProgram
from dubins_study.study.arrays import FloatArray


class NlFile(NamedTuple):
    """The text of a file, and the writer's record.

    The record says where each variable and each row stands.
    """

    text: str
    info: Any


def nl_file(model: Any, title: str = "") -> NlFile:
    """A Pyomo model as an NL file.

    With a title, the first line holds the title and all names.
    """
    from pyomo.repn.plugins.nl_writer import NLWriter

    stream = StringIO()
    info = NLWriter().write(model, stream, linear_presolve=False)
    if not title:
        return NlFile(stream.getvalue(), info)
    names = [v.name.removesuffix(".binary_indicator_var") for v in info.variables]
    # The rest of the first line is the only place for a comment that every reader leaves alone.
    first, _, body = stream.getvalue().partition("\n")
    heading = f"{first.partition('#')[0]}# dubins-study: {title}; variables {' '.join(names)}"
    return NlFile(f"{heading}\n{body}", info)


def pyomo_model(program: MixedProgram, guess: FloatArray | None = None) -> Any:
    """A program in Pyomo.

    Its variables are x[0], x[1], ..., and its objective is f. Its relations g[0], g[1], ... are not
    numbered as the program's rows: a row with two different finite ends makes two of them.
    """
    from pyomo import environ

    m = environ.ConcreteModel()
    m.x = environ.Var(range(program.lower.size))
    for place, (low, high, binary) in enumerate(program.variables):
        variable = m.x[place]
        variable.setlb(low)  # Pyomo takes an infinite bound for none
        variable.setub(high)
        if binary:
            variable.domain = environ.Binary
        if guess is not None:
            variable.set_value(float(guess[place]), skip_validation=True)
    written = program.write(list(m.x.values()), environ)
    m.f = environ.Objective(expr=written.objective)
    m.g = environ.ConstraintList(starting_index=0)
    for row in written.rows:
        for relation in row.relations():
            m.g.add(relation)
    return m
