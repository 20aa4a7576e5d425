"""Pontryagin's system solved as equations: shooting."""
