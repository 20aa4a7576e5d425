"""Routes through points in a given order: proven bounds of their length, and the search."""
