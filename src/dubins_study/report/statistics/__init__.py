"""Pure functions of arrays and frames.

Means, intervals, tests, profiles. No files, no figures.
"""
