"""One module a topic: its numbers, its figures and its section of the page."""
