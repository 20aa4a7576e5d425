"""The committed audit: `report/paper/audit.json`, in the repository and in the wheel.

After an intended change, write the file again with this command:

    dubins-study audit --json > src/dubins_study/report/paper/audit.json

`dubins-study audit` reports whether the code still agrees with the file.
"""

from __future__ import annotations

import json
from functools import lru_cache
from importlib.resources import files
from typing import Any

from dubins_study.errors import DubinsStudyError

NAME = "audit.json"
CORRECT = "correct rounding"


class AuditError(DubinsStudyError, ValueError):
    """The committed audit cannot be read."""


@lru_cache(maxsize=1)
def committed() -> dict[str, Any]:
    """The committed audit, a stored result of `report.paper.audit.audit`.

    Raises:
        AuditError: if it is missing or not a JSON object.
    """
    file = files("dubins_study.report.paper").joinpath(NAME)
    try:
        record = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise AuditError(f"{file} cannot be read: {error}; expected the committed audit") from None
    if not isinstance(record, dict):
        raise AuditError(f"{file} holds {type(record).__name__}; expected an object")
    return record


def misprints() -> list[dict[str, Any]]:
    """The printed cells that are not correct roundings."""
    return [cell for cell in committed()["cells"] if cell["verdict"] != CORRECT]
