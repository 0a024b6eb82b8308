"""Systems of equations for the velocities of a film, and what solves them."""
