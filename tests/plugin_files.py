"""Solvers in `tests/plugins`, for runs that ask them."""

import shutil
from pathlib import Path

PLUGINS = Path(__file__).parent / "plugins"


def spec(file: str, name: str, **settings: object) -> str:
    """Spec of a plug-in in `tests/plugins`.

    It has the path that rows show as well.
    """
    text = f"{PLUGINS / file}.py:{name}"
    if settings:
        text += f"[{','.join(f'{key}={value}' for key, value in settings.items())}]"
    return text


def copied(file: str, folder: Path) -> Path:
    """Copy of a file of plug-ins in a folder.

    Such plug-ins write beside themselves, or their place matters.
    """
    return Path(shutil.copy(PLUGINS / f"{file}.py", folder))
