"""The virtual power of a film: operators at its quadrature points, forms of its elements, forces on its nodes."""
