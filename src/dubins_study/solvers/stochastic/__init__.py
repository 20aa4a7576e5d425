"""Search without derivatives.

It has a penalty function of (4.12), and an adapter for each engine.
"""
