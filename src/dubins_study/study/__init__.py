"""The problem: scenarios, paths, the exact answer, the check and the rows. Knows no solver."""
