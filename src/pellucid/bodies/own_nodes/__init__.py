"""Bodies with their own nodes: the equation of motion of the nodes, in mesh order, and their contact."""
