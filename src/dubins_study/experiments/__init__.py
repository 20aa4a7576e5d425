"""Experiments: what is asked of which solver, and the code that asks and records."""
