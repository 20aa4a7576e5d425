"""Grammar of solver specs: `name[setting=value,...]`.

`{a,b}` stands for several values. A name is one that a solver is registered under, or
`file.py:Class`.
"""

from __future__ import annotations

import itertools
import math
import re
from typing import NamedTuple

from dubins_study.errors import DubinsStudyError


class SolverError(DubinsStudyError, ValueError):
    """A solver or its setting is not usable.

    The solver does not exist, does not extend `Solver`, or has no such setting.
    """


class Spec(NamedTuple):
    """Solver name and the settings given, as texts."""

    name: str
    settings: dict[str, str]


class PluginFile(NamedTuple):
    """File and class that a plug-in's name states."""

    file: str
    class_name: str


_SPEC = re.compile(r"(?P<name>[^\[\]]+?)(?:\[(?P<settings>[^\[\]]*)\])?")


def parse_spec(spec: str) -> Spec:
    """Split a spec into its name and settings.

    Raises:
        SolverError: names the part that does not parse.
    """
    if not isinstance(spec, str):
        raise SolverError(f"solver is {spec!r}; expected a text, name[setting=value]")
    match = _SPEC.fullmatch(spec.strip())
    if match is None:
        raise SolverError(f"solver {spec!r} does not parse; expected name or name[setting=value]")
    settings: dict[str, str] = {}
    for item in filter(None, (match["settings"] or "").split(",")):
        key, equals, value = (part.strip() for part in item.partition("="))
        if not (key and equals and value):
            raise SolverError(f"solver {spec!r}: {item!r} does not parse; expected setting=value")
        if key in settings:
            raise SolverError(f"solver {spec!r}: {key} is given twice; expected each setting once")
        settings[key] = value
    return Spec(match["name"].strip(), settings)


def name_of(spec: str) -> str:
    """Name in a spec.

    The rest of the spec need not parse.
    """
    return spec.partition("[")[0].strip()


def plugin_file(name: str) -> PluginFile | None:
    """Parts of the name `file.py:Class`.

    None for a registered name.
    """
    file, mark, class_name = name.rpartition(".py:")
    if not mark:
        return None
    return PluginFile(f"{file}.py", class_name)


_BRACES = re.compile(r"\{([^{}]*)\}")
# Each pair of braces multiplies the number of specs, so a short line could fill the memory.
MOST_SPECS = 1000


def written_out(spec: str) -> list[str]:
    """Specs that a spec with braces stands for.

    There is one for each combination of the choices in braces: `qp[n={10,20}]` stands for
    `qp[n=10]` and `qp[n=20]`.
    """
    texts = _BRACES.split(spec)  # every second one stood in braces
    if re.search("[{}]", "".join(texts)) or spec.count("[") != spec.count("]"):
        raise SolverError(
            f"solver {spec!r:.80}: its brackets do not match; expected name[setting=value] or "
            "name[setting={a,b}]"
        )
    choices = [[text] for text in texts]
    choices[1::2] = [text.split(",") for text in texts[1::2]]
    if math.prod(map(len, choices)) > MOST_SPECS:
        raise SolverError(
            f"solver {spec!r:.80}: more than {MOST_SPECS} specs, braces written out; expected fewer"
        )
    return ["".join(map(str.strip, choice)) for choice in itertools.product(*choices)]
