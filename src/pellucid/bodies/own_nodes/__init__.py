"""The equation of motion of nodes in the order of their mesh, which bodies with their own nodes share."""
