"""The results folder: write, lock, repair, merge and count.

Parts are written without losing rows.
"""
