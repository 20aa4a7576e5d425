"""The paper's model (4.12) as a nonlinear program: `ipopt`, `slsqp`, and `nlp` for the others."""
