"""`convex`: frozen QPs and SOCPs of routes, put to engines by their own interface or by cvxpy."""
