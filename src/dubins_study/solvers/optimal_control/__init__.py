"""The optimal-control problem (2.2): turn rates as a sequence of QPs, and Radau collocation."""
