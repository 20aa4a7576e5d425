"""The paper's model (4.12) as a nonlinear program, and one adapter for each NLP engine."""
