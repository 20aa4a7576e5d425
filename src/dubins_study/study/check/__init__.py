"""Judge and certify an answer from its controls."""
