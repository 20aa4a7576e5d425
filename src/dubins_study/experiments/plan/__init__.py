"""The cells of an experiment.

A cell has a question, a solver and the digest of its code.
"""
