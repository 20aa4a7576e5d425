"""`python -m dubins_study`: the command line."""

import sys
from pathlib import Path

# `-m` puts the working directory first: a user's `numpy.py` there would be taken for the library
if sys.path[:1] == [str(Path.cwd())]:
    del sys.path[0]

from dubins_study.cli.app import main

if __name__ == "__main__":
    main()
