"""The results folder: write parts without losing rows, lock, repair, merge and count."""
