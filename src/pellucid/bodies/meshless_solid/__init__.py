"""Solids on their own nodes with shape functions over a background mesh, in total-Lagrangian form."""
