"""Mission files in, flights out.

A mission has points to pass; a flight tells where a path is at which time.
"""
