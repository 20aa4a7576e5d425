"""How runs and merges change a results folder's manifest."""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Mapping
from pathlib import Path as FilePath

from dubins_study.experiments.store.whole_file import write_whole
from dubins_study.study.rows.files import ResultsError, os_errors_as
from dubins_study.study.rows.manifest import MANIFEST, Definition, Manifest

# A list of numbers that stand on lines of their own. No text matches: in JSON, line breaks of a
# text are escaped.
_NUMBERS = re.compile(r"\[\n[-+.,\d\seE]+\]")


def write_manifest(folder: FilePath, manifest: Manifest) -> None:
    """Replace the manifest in one step.

    Raises:
        ResultsError: if the folder cannot be written.
    """
    content = manifest.model_dump(by_alias=True)
    text = json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    text = _NUMBERS.sub(lambda match: f"[{' '.join(match[0][1:-1].split())}]", text)
    encoded = text.encode("utf-8", "replace")
    with os_errors_as(f"cannot write {folder / MANIFEST}"):
        write_whole(folder / MANIFEST, lambda file: file.write_bytes(encoded))


def check_same_experiment(folder: FilePath, earlier: Definition, now: Definition) -> None:
    """Refuse a folder that holds another experiment.

    Raises:
        ResultsError: if name or text differ.
    """
    for key, what in (("name", "experiment"), ("text", "text of experiment")):
        value = getattr(earlier, key)
        if value != getattr(now, key):
            raise ResultsError(
                f"{folder} holds results of another {what} ({value!r:.60}), not of "
                f"{now.name!r:.60} as it is now; choose another --out, or --restart to throw them "
                "away"
            )


def continued(manifest: Manifest, earlier: Manifest) -> Manifest:
    """The manifest of a run that goes on with a folder: its origin stays, its solvers add up."""
    return manifest.with_changes(  # whose rows name their own versions
        created=earlier.created,
        finished=earlier.finished,
        solvers={**earlier.solvers, **manifest.solvers},
        runs=earlier.runs,
    )


def count_cells(
    manifest: Manifest, requested: Collection[str], rows: Mapping[tuple[str, str], int]
) -> tuple[Manifest, bool]:
    """Note how many cells the folder is asked for, solver by solver; rows of old code do not count.

    Args:
        manifest: of the folder.
        requested: the specs that this run asks; for other specs, what an earlier run asked stays.
        rows: how many the folder will hold after this run, by spec and code digest.

    Returns:
        The changed manifest, and whether the folder will be finished after this run.
    """
    solvers, complete = {}, True
    for spec, entry in manifest.solvers.items():
        present = rows.get((spec, entry.code_digest), 0)
        cells = present if spec in requested else max(present, entry.cells)
        solvers[spec] = entry.with_changes(cells=cells)
        complete = complete and cells <= present
    total = sum(entry.cells for entry in solvers.values())
    return manifest.with_changes(solvers=solvers, cells=total), complete
