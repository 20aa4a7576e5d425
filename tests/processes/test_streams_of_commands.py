"""Results, progress and colours on their streams.

How a command ends is tested too.
"""

import os
import pty
import select
import signal
import subprocess
import time

import pytest

from tests.live_run import (
    command,
    finished,
    interpreted,
    quick_experiment,
    wait_for,
)
from tests.plugin_files import copied


def in_a_terminal(*arguments, cwd, columns, **environment):
    """Output of a command in a terminal.

    It has both streams, and the exit code comes with it.
    """
    ours, its = pty.openpty()
    import fcntl
    import struct
    import termios

    fcntl.ioctl(its, termios.TIOCSWINSZ, struct.pack("HHHH", 40, columns, 0, 0))
    unset = {"COLUMNS", "NO_COLOR", "FORCE_COLOR"}
    env = {k: v for k, v in os.environ.items() if k not in unset} | {"TERM": "xterm"} | environment
    process = subprocess.Popen(
        command(*arguments), stdin=its, stdout=its, stderr=its, cwd=cwd, env=env
    )
    os.close(its)
    written = b""
    end = time.monotonic() + 300
    while time.monotonic() < end:
        if select.select([ours], [], [], 1)[0]:
            try:
                data = os.read(ours, 65536)
            except OSError:  # the other side is closed
                break
            if not data:
                break
            written += data
    os.close(ours)
    return written.decode(), process.wait(60)


@pytest.fixture
def mine(tmp_path):
    return quick_experiment(tmp_path, 40, "analytic").parent


def test_a_pipe_gets_text_alone(mine):
    """A pipe gets text alone.

    There is no control character on either stream, no progress of a short run, and no broken line.
    """
    done = finished("run", "quick.toml", cwd=mine)

    assert (done.returncode, done.stderr) == (0, "")
    assert "\x1b" not in done.stdout
    assert "40 of 40 cells done" in done.stdout
    assert len([line for line in done.stdout.splitlines() if "analytic" in line]) == 1


@pytest.mark.slow
@pytest.mark.parametrize("columns", [40, 80, 120])
def test_a_terminal_gets_lines_that_fit(mine, columns):
    """Progress is one line; the tables below it fit."""
    written, code = in_a_terminal("run", "quick.toml", cwd=mine, columns=columns)

    assert code == 0
    *_, shown = written.partition("40 of 40 cells done")
    assert "\x1b" not in shown
    assert max(map(len, shown.splitlines())) <= columns
    progress = written.partition("results/quick:")[0]
    assert "40/40" in progress
    assert progress.count("\n") <= 2


def test_ctrl_c_ends_with_130(tmp_path):
    """Ctrl-C ends with 130.

    It ends at once, with a line that says so, and without an answer or a drawing.
    """
    spec = f"{copied('slow', tmp_path)}:Telling"
    process = subprocess.Popen(
        command("solve", 1, 2, "--solver", spec, "--plot", "path.png"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
        env=os.environ | {"NAP": "60"},
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    wait_for(lambda: process.poll() is not None or (tmp_path / "asked").exists())
    process.send_signal(signal.SIGINT)
    out, errors = process.communicate(timeout=60)

    assert process.returncode == 130
    assert out == ""
    assert errors.splitlines()[-1:] == ["dubins-study: interrupted"]
    assert "Traceback" not in errors
    assert not (tmp_path / "path.png").exists()


def test_a_shell_completes_commands_and_options(tmp_path):
    """A shell completes commands and options.

    bash asks for them, with the words so far in the environment.
    """
    for words, expected in (("solve 1 2 --sol", {"--solver"}), ("experi", {"experiments"})):
        line = f"dubins-study {words}"
        asked = {
            "_DUBINS_STUDY_COMPLETE": "complete_bash",
            "COMP_WORDS": line,
            "COMP_CWORD": str(len(line.split()) - 1),
        }
        program = "from dubins_study.cli.app import main; main()"
        done = interpreted(program, cwd=tmp_path, **asked)
        assert set(done.stdout.split()) == expected, done.stderr
