"""Routes through points in a given order.

It holds proven bounds of their length, and the search.
"""
