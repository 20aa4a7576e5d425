"""The command line `dubins-study`: one module per command, joined here.

Results go to stdout, everything else to stderr. Exit code 0: done; 1: done, but something is wrong;
2: the request was bad; 130: interrupted.
"""

from __future__ import annotations

import errno
import os
import sys
from typing import Annotated, Any

from dubins_study.errors import DubinsStudyError

try:
    import typer
except KeyboardInterrupt:  # this is the first import that takes long enough to be interrupted
    sys.exit(130)

from dubins_study.cli import (
    audit,
    check_solver,
    compare,
    experiments,
    export,
    merge,
    new,
    report,
    run,
    solve,
    solvers,
    status,
)
from dubins_study.cli.arguments import NEGATIVE_NUMBERS
from dubins_study.cli.terminal.command_line import CommandLine, Quiet, Verbose
from dubins_study.cli.terminal.verbosity import Verbosity, set_verbosity

_HELP = """Optimisation solvers judged on the shortest Dubins path to a point.

Results go to stdout, progress and refusals to stderr. Exit code 0: done. 1: done, but something is
wrong: an audit, a comparison, a check, or with --strict an answer that is not optimal. 2: the
request was bad. 130: interrupted.
"""
app = CommandLine(text=_HELP)


def _print_version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        print(f"dubins-study {version('dubins-study')}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_print_version, is_eager=True, help="print the version"),
    ] = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    set_verbosity(Verbosity(verbose - quiet))


app.command(context_settings=NEGATIVE_NUMBERS)(solve.solve)
app.command()(solvers.solvers)
app.command()(experiments.experiments)
app.command()(run.run)
app.command()(status.status)
app.command()(merge.merge)
app.command()(report.report)
app.command()(compare.compare)
app.command()(audit.audit)
app.command(context_settings=NEGATIVE_NUMBERS)(export.export)
app.command()(check_solver.check_solver)
app.add_typer(new.app, name="new")


def main() -> Any:
    """The command `dubins-study`. Exit code 2 and one message if the request is bad."""
    try:
        try:
            return app(prog_name="dubins-study")
        finally:
            if sys.stdout is not None:  # it is None where the caller has closed it
                sys.stdout.flush()
    except OSError as error:
        if error.errno not in (errno.EPIPE, errno.ENOSPC):
            raise
        # drop what is not yet written: the interpreter would try once more as it ends
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123, SIM115
        if error.errno == errno.EPIPE:  # the reader has what it wanted
            sys.exit(0)
        print(f"dubins-study: the output cannot be written: {error.strerror}", file=sys.stderr)
        sys.exit(2)
    except DubinsStudyError as error:  # any other exception is a bug and shows its traceback
        from dubins_study.cli.terminal.refusals import refusal_text

        print(refusal_text(str(error)), file=sys.stderr)
        sys.exit(2)
