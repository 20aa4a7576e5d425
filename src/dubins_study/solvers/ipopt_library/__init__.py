"""The Ipopt library of the casadi wheel: a model compiled once, asked many times, with a deadline."""
