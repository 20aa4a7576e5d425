"""Solvers of routes.

A route has several legs, with a final heading or without.
"""
