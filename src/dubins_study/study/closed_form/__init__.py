"""The exact shortest path of every word and of all words, for one scenario or a frame."""
