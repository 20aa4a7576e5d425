"""Which cells an experiment has, of which solvers, with which code digest."""
