"""Damaged experiment files are parsed or refused.

A refusal has a few lines, and never a traceback.
"""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dubins_study.experiments.definition.experiment import ExperimentError, packaged, parse
from tests.fuzz.hostile import LONG_LIVED, MARK
from tests.fuzz.watched import raw_controls

FOLDER = Path(__file__).parents[2] / "src" / "dubins_study" / "experiments"
PACKAGED = [(FOLDER / f"{name}.toml").read_bytes() for name in packaged()]
# characters of a line that quotes what it is about, and lines
LONGEST = 1000
MOST_LINES = 21


def check_lines(message: str) -> None:
    """Check the lines of a refusal.

    There is one line, or a head and an indented line a mistake, none of them without end.
    """
    head, *mistakes = message.split("\n")
    assert len(head) < LONGEST
    assert all(line.startswith("  ") and len(line) < LONGEST for line in mistakes)
    assert len(mistakes) != 1
    assert len(mistakes) <= MOST_LINES


_bits = st.sampled_from(
    [
        *(b"{", b"}", b"[[", b"]]", b'"', b"=", b"\n", b"9" * 40, b"inf", b"nan", b"-", b"0x"),
        *(b"\xff", b"1e999", b"'''", b"[" * 3000, b"true", b"1979-05-27", b"00:00:00"),
        *(b"\\ud800", b"\x00"),
    ]
)


@st.composite
def mutilated(draw: st.DrawFn, originals: list[bytes]) -> bytes:
    """A damaged file.

    Some of its bytes are cut, doubled, replaced or moved.
    """
    content = bytearray(draw(st.sampled_from(originals)))
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, max(0, len(content) - 1)))
        upto = min(len(content), at + draw(st.integers(0, 40)))
        piece = draw(st.one_of(st.binary(max_size=8), st.just(bytes(content[at:upto])), _bits))
        content[draw(st.sampled_from([at, upto])) : upto] = piece
    return bytes(content)


@pytest.mark.smoke
@settings(LONG_LIVED)
@given(content=mutilated(PACKAGED))
def test_a_mutilated_file_is_parsed_or_refused(content):
    text = content.decode("utf-8", "replace")
    try:
        parse("name", f"{MARK}.toml", text)
    except ExperimentError as refusal:
        message = str(refusal)
    else:
        return
    assert message.startswith(f"{MARK}.toml: ")
    assert not raw_controls(message)
    check_lines(message)
