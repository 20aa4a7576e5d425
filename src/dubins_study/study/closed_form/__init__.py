"""The exact shortest path of every word, and the shortest of all: one scenario or a frame of them."""
