"""Exact shortest path of each word and of all.

It is computed for one scenario or a frame.
"""
