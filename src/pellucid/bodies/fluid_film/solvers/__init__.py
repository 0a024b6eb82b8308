"""Solvers of the linear systems for the nodal velocities of a film."""
