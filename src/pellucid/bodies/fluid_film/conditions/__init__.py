"""Constraints of a film: volume, area, prescribed nodal velocities; detection of unbalanced loads."""
