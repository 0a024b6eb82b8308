"""Common parts of membranes of points and of elements."""
