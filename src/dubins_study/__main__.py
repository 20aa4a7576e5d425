"""`python -m dubins_study`: the command line."""

from dubins_study.cli.app import main

if __name__ == "__main__":
    main()
