"""Solvers of the linear systems of equations from which the nodal velocities of a film follow."""
