"""How nodes span a film: curves, triangles with radial functions, Loop subdivision."""
