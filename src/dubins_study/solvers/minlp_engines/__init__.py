"""Adapters of engines that prove a bound.

Each one is for an engine of mixed-integer nonlinear programs.
"""
