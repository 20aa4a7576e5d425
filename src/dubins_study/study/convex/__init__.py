"""Frozen convex problems and their judge.

Their file format, and the proof that judges an answer to one.
"""
