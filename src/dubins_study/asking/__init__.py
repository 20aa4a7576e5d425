"""Questions put to solvers: asked, timed, judged; one at a time, or a frame of them."""
