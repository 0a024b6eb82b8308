"""The contact surface (skin) of a meshless solid: its points, and the response of the body to contact."""
