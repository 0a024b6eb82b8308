"""The virtual power of a film: resistance, stiffness and forces of its elements, and forces on its nodes."""
