"""Write the drawings of README and documentation, `docs/img/problem.svg` and `docs/img/words.svg`.

python docs/draw.py [FOLDER]
"""

from __future__ import annotations

import sys
from pathlib import Path

from dubins_study.report.explorer.drawings import write_drawings

if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "img"
    for file in write_drawings(folder):
        print(file)
