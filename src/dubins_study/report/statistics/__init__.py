"""Numbers from rows, as pure functions."""
