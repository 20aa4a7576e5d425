"""Ipopt for Pyomo models: casadi's library, compiled once and called often, or the executable."""
