"""Pure functions of arrays and frames: means, intervals, tests, profiles. No files, no figures."""
