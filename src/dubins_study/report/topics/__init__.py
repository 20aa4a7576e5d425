"""One module per topic.

Each has the numbers, the figures and the section of its topic.
"""
