"""One trivial solver under three harnesses.

The difference of their times is the cost of a cell.
"""
