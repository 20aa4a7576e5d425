"""Compare two runs solver by solver: what became better or worse, and where."""
