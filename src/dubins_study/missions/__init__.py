"""Mission files in, flights out: points to pass, and where a path is at which time."""
