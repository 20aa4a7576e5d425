"""Frozen convex problems: their file format, and the proof that judges an answer to one."""
