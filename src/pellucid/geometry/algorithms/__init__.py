"""Computational geometry: point-in-surface tests, intersections, quadrature, spatial ordering of points, second moments."""
