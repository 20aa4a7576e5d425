"""Turns on a grid of headings, chosen by a mixed-integer linear program."""
