"""The paper's model (4.12) as a nonlinear program: `nlp`, and its presets `slsqp` and `ipopt`."""
