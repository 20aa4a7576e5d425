"""`python -m dubins_study`: the command line."""

import os
import sys

# `-m` puts the working directory first: a user's `numpy.py` there would be ours, and our workers'
if sys.path[:1] == [os.getcwd()]:
    del sys.path[0]

from dubins_study.cli.app import main  # noqa: E402

if __name__ == "__main__":
    main()
