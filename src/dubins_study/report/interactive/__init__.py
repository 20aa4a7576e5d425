"""Embed a sample of single attempts in the page, with their paths and a library that plots them."""
