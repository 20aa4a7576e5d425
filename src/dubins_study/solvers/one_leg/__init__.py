"""The paper's model (4.12) of one leg: its cases, initial guesses, and the way to the target."""
