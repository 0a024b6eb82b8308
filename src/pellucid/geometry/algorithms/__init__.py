"""Computational geometry: points in surfaces, crossings, quadrature, orders in space, moments."""
