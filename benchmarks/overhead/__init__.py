"""One trivial solver under three harnesses: what a cell costs beyond it."""
