"""The message for a package that is not installed."""

from __future__ import annotations

import re
import sys
from importlib.metadata import requires
from typing import NoReturn

_PACKAGES = {"flint": "python-flint"}  # module -> package, where their names differ


def refuse_missing(error: ModuleNotFoundError) -> NoReturn:
    """End with the name of a missing package.

    The exit code is 2. The package must be one that dubins-study uses.

    Raises:
        ModuleNotFoundError: the error, of any other module: that is a bug.
    """
    package = _PACKAGES.get(error.name or "", error.name)
    requirements = requires("dubins-study") or ()
    used = {re.split(r"[^\w-]", requirement)[0] for requirement in requirements}
    if package not in used:
        raise error
    reason = f"the package {package} is not installed; pip install {package}"
    print(f"dubins-study: {reason}", file=sys.stderr)
    sys.exit(2)
