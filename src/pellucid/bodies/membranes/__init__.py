"""Code shared by membranes of points and of elements."""
