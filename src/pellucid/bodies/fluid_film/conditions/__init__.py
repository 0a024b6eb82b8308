"""Constraints of a film (volume, area, prescribed nodal velocities), and the error for loads that no resistance balances."""
