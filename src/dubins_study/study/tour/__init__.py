"""The shortest tour: the search, its bounds, and the orders that it begins and ends with."""
