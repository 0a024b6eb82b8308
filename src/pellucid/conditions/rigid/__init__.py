"""Rigid bodies: their free and prescribed motion, the nodes around them, walls that stop them, and fluids that do not slip
on them."""
