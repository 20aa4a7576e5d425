"""Answers judged and certified, by the table of kinds: one at a time, and by frames."""
