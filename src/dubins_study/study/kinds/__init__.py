"""Table of the kinds of questions.

A kind states how a question is recognised, answered, judged and drawn.
"""
