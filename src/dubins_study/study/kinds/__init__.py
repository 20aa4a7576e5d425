"""Kinds of questions: how each is recognised, answered, judged and drawn; one table of them."""
