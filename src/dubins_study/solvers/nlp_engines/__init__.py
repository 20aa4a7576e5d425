"""One adapter for each engine of nonlinear programs; the programs come from the formulations."""
