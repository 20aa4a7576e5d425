"""The shortest path proven by a global solver: (4.12), or a disjunction of words."""
