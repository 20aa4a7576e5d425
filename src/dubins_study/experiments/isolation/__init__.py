"""Solve one question in a process that can be killed; this room knows nothing of cells or rows."""
