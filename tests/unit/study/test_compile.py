"""Keys of a loop's cache.

They are the sources that it can depend on, and no others.
"""

import sys
from pathlib import Path

import pytest
from numba.core.dispatcher import Dispatcher

from dubins_study.study.closed_form import kernel_compile
from dubins_study.study.closed_form.kernel_compile import PIECE, PIECES, SMALL, threaded
from dubins_study.study.judging import verdict_frame  # noqa: F401  # loads the loops of frames
from dubins_study.study.route import search  # noqa: F401  # loads those of routes

PACKAGE = Path(kernel_compile.__file__).parents[2]


def test_an_edit_outside_the_problem_compiles_nothing_anew():
    """An edit outside the problem compiles nothing.

    The compiled loops and what they call lie in the sources of the key; the report does not.
    """
    modules = [name for name in sys.modules if name.startswith("dubins_study.")]
    dispatchers = [
        value
        for name in modules
        for value in vars(sys.modules[name]).values()
        if isinstance(value, Dispatcher)
    ]
    functions = [dispatcher.py_func for dispatcher in dispatchers] + [*kernel_compile._callable]
    files = {Path(function.__code__.co_filename) for function in functions}

    assert len(files) > 10
    assert files <= set(kernel_compile._FILES)
    rooms = {file.relative_to(PACKAGE).parts[0] for file in kernel_compile._FILES}
    assert rooms == {"study"}


@pytest.mark.parametrize("n", [0, 1, SMALL - 1, SMALL, SMALL + 1, 7 * PIECE * PIECES + 5])
@pytest.mark.parametrize("threads", [1, 2, 3])
def test_every_row_is_done_once(n, threads, monkeypatch):
    """Every row is done once.

    Pieces begin at multiples of `PIECE`, and an error in one is the caller's.
    """
    monkeypatch.setattr(kernel_compile.numba.config, "NUMBA_NUM_THREADS", threads)
    monkeypatch.setattr(kernel_compile, "compiled", lambda function: function)
    pieces = []

    threaded(lambda begin, end, into: into.append((begin, end)))(n, pieces)

    pieces.sort()
    ends = [end for _, end in pieces]
    assert [begin for begin, _ in pieces] == [0, *ends[:-1]]
    assert ends[-1] == n
    assert all(begin % PIECE == 0 for begin, _ in pieces)
    assert (len(pieces) > 1) == (n >= SMALL and threads > 1)


def test_an_error_in_a_thread_is_raised(monkeypatch):
    monkeypatch.setattr(kernel_compile.numba.config, "NUMBA_NUM_THREADS", 2)
    monkeypatch.setattr(kernel_compile, "compiled", lambda function: function)

    with pytest.raises(ZeroDivisionError):
        threaded(lambda begin, end: 1 / (begin - begin))(2 * SMALL)
