"""The equation of motion for bodies with their own nodes, in mesh order."""
