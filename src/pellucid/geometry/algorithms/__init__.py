"""Computational geometry: tests whether points lie inside surfaces, intersections, quadrature, spatial ordering of points,
second moments."""
