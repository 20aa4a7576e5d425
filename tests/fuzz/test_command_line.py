"""Any words after `dubins-study` are answered or refused.

There is one refusal, and never a traceback.
"""

import re
import shutil

import pytest
import scipy.stats  # noqa: F401
from hypothesis import given, settings
from hypothesis import strategies as st

# loaded here, as scipy.stats is, since a module may write a cache file when first loaded
import dubins_study.cli.app
import dubins_study.cli.terminal.output
import dubins_study.report.page.render  # noqa: F401
from tests.fuzz.hostile import HOSTILE, LONG_LIVED
from tests.fuzz.page import check_json
from tests.fuzz.watched import command, raw_controls, temporary_files_in

# what no argument of a process can hold
_WORDS = [text for text in HOSTILE if "\x00" not in text] + ["\udcff", "x" * 300, "é\udc80"]
_NUMBERS = st.one_of(
    st.sampled_from(["0", "1", "-1", "10", "1e308", "-1e308", "1e-320", "nan", "inf", "9" * 400]),
    st.sampled_from(["1e16", "1_0", "٣", "0x10", "120deg", "pi", "1e3000", "", " 1 ", "1,5"]),
    st.floats(-20, 20).map(str),
)
_PLACES = st.sampled_from(
    [
        *("new", "a/b/c", "file", "full", "file/x", "empty", "link", "dangling", "loop"),
        *("gone/../new2", "folder.toml", "plain.toml", ".", "[a]", "**", "*", "path.svg"),
        *("path.png", "x.pdf", "run", "run2", "run/parts", "run/manifest.json", "\udcff"),
        *("\x1b[31m", "n" * 300, "a\nb", "~", "empty.svg", "dev.svg", "[/b].toml", "..toml"),
        *("drive.csv", "damaged.csv", "file.parquet", "..csv"),
        "...toml",
    ]
)
_JUNK = st.one_of(st.sampled_from(_WORDS), _NUMBERS, _PLACES)


def _option(name: str, *values: st.SearchStrategy[str]) -> st.SearchStrategy[list[str]]:
    """An option with values.

    They fit, or do not; there may be too many, or none.
    """
    right = st.tuples(st.just(name), *values).map(list)
    odd = st.tuples(st.just(name), st.lists(_JUNK, max_size=4)).map(lambda p: [p[0], *p[1]])
    joined = st.tuples(*values, _JUNK).map(lambda p: [f"{name}={p[0]}"])
    return st.one_of(right, right, right, odd, joined)


_TARGET = st.lists(_NUMBERS, min_size=2, max_size=2)
_SOLVERS = st.sampled_from(["analytic", "analytic[a=1]", "no", "slsqp[", "canary.pyc", "x.toml:Y"])
_POSE = _option("--from", _NUMBERS, _NUMBERS, _NUMBERS)
# every command with words that fit it, and options that do
_COMMANDS: dict[str, tuple[st.SearchStrategy[list[str]], list[st.SearchStrategy[list[str]]]]] = {
    "solve": (
        _TARGET,
        [
            *(_POSE, _option("--radius", _NUMBERS), _option("--speed", _NUMBERS)),
            *(
                _option("--time-limit", _NUMBERS),
                _option("--solver", _SOLVERS),
                st.just(["--json"]),
            ),
            _option("--branch", st.sampled_from(["best", "LS", "RL", "SL"])),
            _option("--profile", st.sampled_from(["default", "accurate", "no"])),
            st.just(["--strict"]),
            _option("--via", _NUMBERS, _NUMBERS).map(lambda words: [*words, "--time-limit", "0.2"]),
            _option("--final-heading", _NUMBERS),
            _option("--via-file", _PLACES),
            _option("--geojson", _PLACES),
        ],
    ),
    "export": (
        _TARGET,
        [
            *(_POSE, _option("--radius", _NUMBERS), _option("--out", _PLACES)),
            _option("--model", st.sampled_from(["paper", "disjunctive"])),
            _option("--format", st.sampled_from(["nl", "gams", "mod"])),
            _option("--order", st.sampled_from(["LRS", "RLS"])),
        ],
    ),
    "experiments": (st.just([]), [st.just(["--json"])]),
    "status": (_PLACES.map(lambda p: [p]), [st.just(["--json"])]),
    "merge": (st.lists(_PLACES, max_size=3), [_option("--out", _PLACES)]),
    "report": (st.lists(_PLACES, max_size=2), [_option("--out", _PLACES)]),
    "run": (
        _PLACES.map(lambda p: [p]),
        [
            *(_option("--out", _PLACES), _option("--time-limit", _NUMBERS), st.just(["--restart"])),
            *(
                _option("--memory-limit", _NUMBERS),
                _option("--solver", _SOLVERS),
                st.just(["--trust-plugins"]),
            ),
            _option("--jobs", st.sampled_from(["1", "0", "-1", "9" * 30, "1.5"])),
            _option("--scenarios", _PLACES),
            _option("--repeats", st.sampled_from(["0", "-1", "9" * 30, "1000000000", "x"])),
        ],
    ),
    "": (st.lists(_JUNK, max_size=3), []),
}


@st.composite
def requests(draw: st.DrawFn, plots: bool = False) -> list[str]:
    """A command line, often wrong.

    It is mostly as the help says, with something missing, doubled or out of place.
    """
    name = "solve" if plots else draw(st.sampled_from(list(_COMMANDS)))
    words, options = _COMMANDS[name]
    chosen = draw(st.lists(st.one_of(*options), max_size=4)) if options else []
    groups = [*chosen, draw(words), *([draw(_option("--plot", _PLACES))] if plots else [])]
    made = [name, *(word for group in draw(st.permutations(groups)) for word in group)]
    how = draw(st.sampled_from(["", "", "", "drop", "double", "junk", "help"]))
    at = draw(st.integers(0, len(made) - 1))
    if how == "drop":
        del made[at]
    elif how == "double":
        made.insert(at, made[at])
    elif how == "junk":
        made.insert(at, draw(_JUNK))
    elif how == "help":
        made.append("--help")
    return made


@pytest.fixture(scope="module")
def place(tmp_path_factory, small_run, song):
    """A working directory with all kinds of things."""
    folder = tmp_path_factory.mktemp("outer") / "inner"
    folder.mkdir()
    (folder / "file").write_text("text")
    for name in ("full", "empty", "folder.toml", "empty.svg", "[a]", "["):
        (folder / name).mkdir()
    (folder / "full" / "file").write_text("text")
    (folder / "plain.toml").write_text("title = 1")
    head = "target_x,target_y,x,y,heading,radius\n"
    (folder / "drive.csv").write_text(f"{head}3,2,0,0,0,1\n4,2,0,0,30deg,1\n")
    (folder / "damaged.csv").write_text(f'{head}3,2,"0\x1b[31m\n",0,0,-1\n4,2\n')
    (folder / "file.parquet").write_bytes(b"PAR1 and no more PAR1")
    shutil.copy(small_run.experiment, folder / "[/b].toml")
    (folder / "link").symlink_to("empty")
    (folder / "dangling").symlink_to("nowhere")
    (folder / "loop").symlink_to("loop")
    (folder / "dev.svg").symlink_to("/dev/full")
    for name in ("run", "run2"):
        shutil.copytree(small_run.folder, folder / name)
    patch = pytest.MonkeyPatch()
    patch.chdir(folder)
    yield folder
    patch.undo()


# what only holds other commands gets help where none of them is named
_GROUPS = ([], ["new"])


@settings(LONG_LIVED)
@given(words=st.one_of(requests(), requests(), requests(), requests(plots=True)))
def test_a_request_is_answered_or_refused(words, place, song):
    outer = sorted(place.parent.iterdir())
    with temporary_files_in(place):
        result = command(*words)
    assert result.code in (0, 1, 2)
    assert "Traceback" not in result.out + result.err
    if result.code == 2:
        # an answer is kept if its drawing fails
        assert not result.out or any(word.startswith("--plot") for word in words)
        if words not in _GROUPS:
            assert re.fullmatch(r"dubins-study: [^\n]+\n(  [^\n]+\n)*", result.err)
            assert not raw_controls(result.err)
    else:
        assert result.out or any(word.startswith("--out") for word in words)
        assert not raw_controls(result.out)
        if "--json" in words and "--help" not in words:
            check_json(result.out)
    assert not song.exists()
    assert sorted(place.parent.iterdir()) == outer
