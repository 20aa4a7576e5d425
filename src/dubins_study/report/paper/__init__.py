"""What the paper prints, and the audit of it."""
