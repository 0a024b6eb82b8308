"""Meshless solids: nodes that move by their own equation of motion, with shape functions over a background mesh, in
total-Lagrangian form."""
