"""Shooting: Pontryagin's system solved as equations."""
