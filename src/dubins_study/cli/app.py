"""The command line `dubins-study`: all commands in one.

Each command has a module of its own. `_HELP` tells more.
"""

from __future__ import annotations

import errno
import os
import re
import signal
import sys
from collections.abc import Callable, Sequence
from typing import Annotated, Any

from dubins_study.cli.terminal.missing import refuse_missing
from dubins_study.errors import DubinsStudyError

try:
    import typer
    from typer.core import TyperCommand
    from typer.exceptions import TyperException

    from dubins_study.cli import (
        audit,
        check_solver,
        compare,
        experiments,
        export,
        judge,
        merge,
        new,
        report,
        run,
        solve,
        solvers,
        status,
    )
    from dubins_study.cli.terminal.arguments import PAIRS
    from dubins_study.cli.terminal.output import Verbosity, plain, set_verbosity
    from dubins_study.cli.terminal.slips import arranged
    from dubins_study.experiments.interruption import Interruption
except KeyboardInterrupt:  # these imports take long enough to be interrupted
    sys.exit(130)
except ModuleNotFoundError as absent:
    refuse_missing(absent)

PROGRAM = "dubins-study"
_HELP = """Optimisation solvers judged on the shortest Dubins path to a point.

Results go to stdout, progress and refusals to stderr. Exit code 0: done. 1: done, but something is
wrong: an audit, a comparison, a check, or with --strict an answer that is not optimal. 2: the
request was bad. 130: interrupted.
"""
# Examples at the end of the help of the commands that they call. A test runs them in this order in
# one folder that holds drive.csv: later ones read what earlier ones wrote.
EXAMPLES = """\
dubins-study solve 10 5 --from 0 0 120deg --radius 1
dubins-study solve -6 3 --solver 'turn-rate-qp[n=100]' --plot path.svg
dubins-study solve 0.5 0 --branch LR --json
dubins-study solve 10 5 --via 4 1 --via 6 -2 --final-heading 90deg
dubins-study solvers
dubins-study solvers ipopt
dubins-study solvers --json
dubins-study experiments
dubins-study experiments paper
dubins-study experiments --json
dubins-study new solver my_solver.py
dubins-study new experiment my.toml
dubins-study run paper
dubins-study run paper --solver ipopt --solver slsqp --out mine
dubins-study run my.toml --jobs 2
dubins-study run --scenarios drive.csv --solver ipopt --solver slsqp
dubins-study status results/paper
dubins-study status results/paper --json
dubins-study merge results/paper mine --out both
dubins-study report results/paper
dubins-study compare results/paper both --out changes
dubins-study compare results/paper both --fail-on-regression
dubins-study check-solver my_solver.py:MySolver
dubins-study check-solver slsqp --check limits --check state
dubins-study audit
dubins-study audit kaya
dubins-study export 10 5 --from 0 0 120deg --format mod
dubins-study export 10 5 --model disjunctive --out model.nl
dubins-study export my.toml --formulation paper --out set
dubins-study judge set/instances.csv --suite my.toml --out judged
""".splitlines()
Quiet = Annotated[
    bool, typer.Option("--quiet", "-q", help="no progress on stderr: only warnings and refusals")
]
Verbose = Annotated[bool, typer.Option("--verbose", "-v", help="every step on stderr")]


def _verbosity(quiet: Quiet = False, verbose: Verbose = False) -> None:
    # -1, 0 or 1: together the two options cancel out
    set_verbosity(Verbosity(verbose - quiet))


_of_all = typer.Typer(add_completion=False)
_of_all.command()(_verbosity)
_SHARED = typer.main.get_command(_of_all).params  # the options --quiet and --verbose


class _Command(TyperCommand):
    """A command with --quiet and --verbose.

    Negative numbers are no options, and Ctrl-C ends the command with exit code 130.
    """

    def __init__(self, *arguments: Any, **settings: Any) -> None:
        super().__init__(*arguments, **settings)
        self.params += _SHARED
        for option in self.params:
            if option.name in PAIRS:
                option.nargs = 2  # typer knows no list of pairs

    def invoke(self, ctx: Any) -> Any:
        try:
            with Interruption((signal.SIGINT,), at_once=True):  # a library may swallow it
                return super().invoke(ctx)
        except (KeyboardInterrupt, SystemError) as error:
            # a compiled loop turns an interruption into a SystemError
            if KeyboardInterrupt not in (type(error), type(error.__cause__)):
                raise
            print(f"{PROGRAM}: interrupted", file=sys.stderr)
            raise typer.Exit(130) from None

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        leftover = super().parse_args(ctx, arranged(args, self.get_params(ctx), ctx.fail))
        shared = {name: ctx.params.pop(name, False) for name in ("quiet", "verbose")}
        if any(shared.values()):  # otherwise what stands before the command's name holds
            _verbosity(**shared)
        return leftover


def examples(words: str) -> list[str]:
    """The examples of a command, or of the program.

    `words` is a command, such as `new` or `new solver`. Empty, it stands for the program, which has
    one example each of three commands.
    """
    if not words:
        return [examples(name)[0] for name in ("solve", "run", "report")]
    return [line for line in EXAMPLES if f"{line} ".startswith(f"{PROGRAM} {words} ")]


def _epilog(words: str) -> str:
    # \b keeps the lines of a paragraph as they are
    return "\n".join(["\b", "Examples:", *(f"  {line}" for line in examples(words))])


def _print_version(requested: bool) -> None:
    if requested:
        from importlib.metadata import version

        print(f"{PROGRAM} {version(PROGRAM)}")
        raise typer.Exit


def _group(words: str, text: str, functions: Sequence[Callable[..., None]]) -> typer.Typer:
    """Commands behind `words`, called like their functions.

    The help of each command ends with examples.
    """
    group = typer.Typer(
        help=text,
        no_args_is_help=True,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
        context_settings={"help_option_names": ["-h", "--help"]},
        epilog=_epilog(words),
    )
    for function in functions:
        name = function.__name__.replace("_", "-")
        epilog = _epilog(f"{words} {name}".strip())
        group.command(name, cls=_Command, epilog=epilog)(function)
    return group


app = _group(
    "",
    _HELP,
    [
        solve.solve,
        solvers.solvers,
        experiments.experiments,
        run.run,
        status.status,
        merge.merge,
        report.report,
        compare.compare,
        audit.audit,
        export.export,
        judge.judge,
        check_solver.check_solver,
    ],
)
app.add_typer(
    _group("new", "Write a file to begin with.", [new.solver, new.experiment]), name="new"
)


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_print_version, is_eager=True, help="print the version"),
    ] = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    _verbosity(quiet, verbose)


def main() -> None:
    """The command `dubins-study`.

    If the request is bad, it prints one message and exits with code 2.
    """
    try:
        try:
            sys.exit(app(prog_name=PROGRAM, standalone_mode=False) or 0)
        finally:
            if sys.stdout is not None:  # it is None where the caller has closed it
                sys.stdout.flush()
    except OSError as error:
        if error.errno not in (errno.EPIPE, errno.ENOSPC):
            raise
        # drop the rest of the output: the interpreter would try to write it as it ends
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123, SIM115
        if error.errno == errno.EPIPE:  # the reader has what it wanted
            sys.exit(0)
        _refuse(f"the output cannot be written: {error.strerror}")
    except TyperException as error:
        message = error.format_message()
        if message.startswith("Usage:"):  # the help of a group without a command
            print(message, file=sys.stderr)
            sys.exit(2)
        context = getattr(error, "ctx", None)
        command = getattr(context, "command_path", PROGRAM)
        _refuse(f"{message.rstrip('.')}; see {command} --help")
    except ModuleNotFoundError as error:
        refuse_missing(error)
    except DubinsStudyError as error:  # any other exception is a bug and shows its traceback
        _refuse(str(error))


def _refuse(message: str) -> None:
    """End with exit code 2 and a message.

    A line break before two spaces stays: they begin an item of a list. Any other line break is
    written as an escape.
    """
    lines = re.split(r"\n(?=  )", f"{PROGRAM}: {message}")
    print(*map(plain, lines), sep="\n", file=sys.stderr)
    sys.exit(2)
