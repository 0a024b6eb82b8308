"""Solids on nodes of their own with shape functions over a background mesh, in total-Lagrangian form."""
