"""The paper's model (4.12) as a nonlinear program.

The solvers are `nlp`, and its presets `slsqp` and `ipopt`.
"""
