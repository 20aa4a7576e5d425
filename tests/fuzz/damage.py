"""Accidents that befall a results folder.

Files are cut, flipped, mixed, doubled or gone.
"""

import random
import shutil
from pathlib import Path


def _part(folder: Path, dice: random.Random) -> Path:
    return dice.choice(sorted((folder / "parts").iterdir()))


def flip(folder: Path, dice: random.Random) -> None:
    """Flip some bits of a part.

    They lie in its rows or in the metadata at its end.
    """
    part = _part(folder, dice)
    content = bytearray(part.read_bytes())
    first = dice.choice([0, max(0, len(content) - 3000)])
    for _ in range(dice.randint(1, 8)):
        content[dice.randrange(first, len(content))] ^= 1 << dice.randrange(8)
    part.write_bytes(content)


def overwrite(folder: Path, dice: random.Random) -> None:
    """Overwrite four bytes, as a bad block does."""
    part = _part(folder, dice)
    content = bytearray(part.read_bytes())
    at = dice.randrange(len(content) - 4)
    content[at : at + 4] = b"\xff" * 4
    part.write_bytes(content)


def cut(folder: Path, dice: random.Random) -> None:
    """Cut the manifest or a part.

    A copy that did not finish leaves such a file.
    """
    file = dice.choice([folder / "manifest.json", _part(folder, dice)])
    content = file.read_bytes()
    file.write_bytes(content[: dice.randrange(len(content))])


def lengthen(folder: Path, dice: random.Random) -> None:
    part = _part(folder, dice)
    content = bytearray(part.read_bytes())
    at = dice.randrange(len(content))
    content[at:at] = dice.randbytes(dice.randint(1, 50))
    part.write_bytes(content)


def mix(folder: Path, dice: random.Random) -> None:
    """Join the beginning and end of two parts."""
    one, other = _part(folder, dice), _part(folder, dice)
    content, end = one.read_bytes(), other.read_bytes()
    at = dice.randrange(len(content))
    one.write_bytes(content[:at] + end[at:])


def double(folder: Path, dice: random.Random) -> None:
    """Copy a part beside itself.

    A program that syncs folders leaves such a copy and a temporary file.
    """
    shutil.copyfile(_part(folder, dice), folder / "parts" / "copy.parquet")
    (folder / "parts" / "copy.parquet.tmp").write_bytes(b"PAR1")


def lose(folder: Path, dice: random.Random) -> None:
    _part(folder, dice).unlink()


DAMAGES = (flip, overwrite, cut, lengthen, mix, double, lose)
