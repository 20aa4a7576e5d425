"""Judge and certify answers, by the table of kinds.

Answers are judged one at a time, and by frames.
"""
