"""The optimal-control problem (2.2): turn rates, multiple shooting, and Radau collocation."""
