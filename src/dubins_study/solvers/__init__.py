"""Solvers: their base class, the registry and all backends."""
