"""The command `dubins-study solve`, in parts.

Words become a question, an answer becomes text.
"""
