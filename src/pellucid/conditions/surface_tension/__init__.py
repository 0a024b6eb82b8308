"""Surface tension of fluids of material points, and their contact angle at walls."""
