"""Search for the shortest tour.

It holds the search, its bounds, and the orders that it begins and ends with.
"""
