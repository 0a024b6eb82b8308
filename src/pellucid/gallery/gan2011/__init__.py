"""Gan, Chen & Montgomery-Smith 2011: membranes as material points, shocks, failure of the zona (the shell of an oocyte)."""
