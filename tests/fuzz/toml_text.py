"""Experiments as TOML texts: valid ones, and what strangers make of them."""

from __future__ import annotations

import copy
from typing import Any

from hypothesis import strategies as st

from dubins_study.experiments.definition.scenario_block import FIELDS
from tests.fuzz.hostile import integers, nested, scalars, texts

SPECS = (
    *("analytic", "*", "slsqp[count=3]", "slsqp[count={1,2}]", "ipopt", "turn-rate-qp[n=50]"),
    *("nlp[engine=canary]", "nlp[engine=../canary]", "nlp[engine=/bin/sh]", "ipopt[engine={a,b}]"),
    *("CANARY", "CANARY[a=1]", " CANARY ", "{CANARY,analytic}", "analytic[x=CANARY]"),
    *("canary.py:Canary", "~/canary.py:Canary", "{canary,a}.py:Canary", "nlp[engine={canary}]"),
    *("slsqp" + "[", "slsqp]", "slsqp[count={1,2]", "slsqp[count=}", "{", "{}", "{,}", "[]", "x[]"),
    *("slsqp[count={1,{2,3}}]", "{analytic,}" * 40, "{" * 3000 + "}" * 3000, "{a,b}" * 2000),
    *("slsqp[count=" + "9" * 5000 + "]", "slsqp[count=1e999]", "slsqp[count=nan,count=2]"),
    *(
        "slsqp[__class__=1]",
        "analytic[__init__=x]",
        "dubins_study.solvers.paper_nlp.slsqp:Slsqp",
        "os:system",
    ),
)


def quoted(text: str) -> str:
    """A TOML basic string; what it cannot hold is left out."""
    made = []
    for letter in text:
        number = ord(letter)
        if 0xD800 <= number < 0xE000:
            continue
        plain = number >= 32 and number != 127 and letter not in '"\\'
        made.append(letter if plain else f"\\U{number:08x}")
    return '"' + "".join(made) + '"'


def value(given: Any) -> str:
    """A value as TOML writes it, tables in one line."""
    if isinstance(given, bool):
        return str(given).lower()
    if isinstance(given, str):
        return quoted(given)
    if isinstance(given, int):
        # Python reads decimals of at most 4300 digits, hexadecimals of any length
        return str(given) if given < 0 or given < 10**3000 else hex(given)
    if isinstance(given, float):
        return repr(given)
    if isinstance(given, dict):
        inner = {quoted(str(key)): value(item) for key, item in given.items()}
        return "{" + ", ".join(f"{key} = {item}" for key, item in inner.items()) + "}"
    return "[" + ", ".join(value(item) for item in given) + "]"


def text_of(fields: dict[str, Any]) -> str:
    """A file's text."""
    return "\n".join(f"{quoted(str(key))} = {value(item)}" for key, item in fields.items())


# cells, and too many for any machine
_counts = st.sampled_from([1, 2, 3, 150, 10**6, 10**9])
_axes = st.one_of(
    st.sampled_from([0.5, 1.0, 3.0, "120deg", "pi/3", [1.0, 2.0], ["2pi/3", 1]]),
    st.builds(lambda n: {"linear": [1, 3, n]}, _counts),
    st.builds(lambda n: {"log": [1, 3, n]}, _counts),
)
_samples = st.builds(
    lambda method, count, ranges: {"method": method, "count": count, "seed": 1, "ranges": ranges},
    st.sampled_from(["sobol", "latin hypercube"]),
    _counts,
    st.dictionaries(
        st.sampled_from(["heading", "speed", "radius"]),
        st.sampled_from([{"linear": [1, 2]}, {"log": [1, 2]}]),
        min_size=1,
    ),
)
_blocks = st.fixed_dictionaries(
    {"target_x": _axes, "target_y": st.just(4.0)},
    optional={
        "label": texts,
        "heading": _axes,
        "sample": _samples,
        "solvers": st.lists(st.sampled_from(SPECS[:6]), min_size=1, max_size=2),
        "branches": st.lists(st.sampled_from(["best", "LS", "RL"]), min_size=1, max_size=2),
        "guess_lengths": st.fixed_dictionaries({"z1": _axes, "z2": _axes, "z3": _axes}),
    },
)
valid = st.fixed_dictionaries(
    {
        "title": st.just("t"),
        "question": st.just("q"),
        "solvers": st.lists(st.sampled_from(SPECS[:6]), min_size=1, max_size=2),
        "scenarios": st.lists(_blocks, min_size=1, max_size=2),
    },
    optional={
        "initial_guesses": st.lists(st.sampled_from(["cold", "warm"]), min_size=1, max_size=2),
        "repeats": _counts,
        "time_limit_s": st.sampled_from([1, 0.5, 1e9]),
        "memory_limit_gib": st.sampled_from([0.25, 4]),
        "seed": st.sampled_from([0, 7, 2**63 - 1]),
        "profile": st.sampled_from(["default", "fast", "accurate"]),
    },
)
_odd = st.one_of(scalars, nested(scalars), st.lists(st.sampled_from(SPECS), min_size=1, max_size=3))
_keys = st.one_of(st.sampled_from(FIELDS), texts)


@st.composite
def experiments(draw: st.DrawFn) -> dict[str, Any]:
    """A valid experiment, mostly with something in it that is none."""
    fields = copy.deepcopy(draw(valid))
    for _ in range(draw(st.integers(0, 2))):
        _spoil(draw, fields)
    if draw(st.booleans()):
        fields["solvers"] = draw(st.lists(st.sampled_from(SPECS), min_size=1, max_size=3))
    return fields


def _spoil(draw: st.DrawFn, fields: dict[str, Any]) -> None:
    """Change, add or take away one thing anywhere."""
    place: Any = fields
    while True:
        keys = list(place) if isinstance(place, dict) else list(range(len(place)))
        key = draw(st.sampled_from(keys)) if keys else None
        inner = place[key] if key is not None else None
        if isinstance(inner, dict | list) and inner and draw(st.booleans()):
            place = inner
            continue
        break
    how = draw(st.sampled_from(["change", "add", "drop"]))
    if how == "add" and isinstance(place, dict):
        place[draw(_keys)] = draw(_odd)
    elif how == "drop" and key is not None:
        del place[key]
    elif key is not None:
        place[key] = draw(st.one_of(_odd, integers))


@st.composite
def mutilated(draw: st.DrawFn, originals: list[bytes]) -> bytes:
    """A file with some of its bytes cut, doubled, replaced or moved."""
    content = bytearray(draw(st.sampled_from(originals)))
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, max(0, len(content) - 1)))
        upto = min(len(content), at + draw(st.integers(0, 40)))
        piece = draw(st.one_of(st.binary(max_size=8), st.just(bytes(content[at:upto])), _bits))
        content[draw(st.sampled_from([at, upto])) : upto] = piece
    return bytes(content)


_bits = st.sampled_from(
    [
        *(b"{", b"}", b"[[", b"]]", b'"', b"=", b"\n", b"9" * 40, b"inf", b"nan", b"-", b"0x"),
        *(b"\xff", b"1e999", b"'''", b"[" * 3000, b"true", b"1979-05-27", b"00:00:00"),
        *(b"\\ud800", b"\x00"),
    ]
)
