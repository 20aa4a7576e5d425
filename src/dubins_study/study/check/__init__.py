"""Judges and certifies an answer from its controls alone."""
