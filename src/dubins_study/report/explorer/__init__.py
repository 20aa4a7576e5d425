"""Every word's path to a target that the reader drags: part of the page, and a page of its own."""
