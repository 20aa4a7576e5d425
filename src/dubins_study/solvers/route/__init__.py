"""Solvers of routes: several legs, with a final heading or without."""
