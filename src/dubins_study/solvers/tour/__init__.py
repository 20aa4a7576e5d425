"""Tours: formulations that choose the order of the points and the headings there."""
