"""`convex`: frozen QPs and SOCPs of routes.

Engines get them by their own interface or by cvxpy.
"""
