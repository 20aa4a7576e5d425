"""The shortest path as a disjunction of words, proven by a global solver."""
