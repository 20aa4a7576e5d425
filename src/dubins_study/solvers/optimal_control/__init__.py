"""The optimal-control problem (2.2) itself: turn rates as a sequence of QPs, and Radau collocation."""
