"""A concentration that diffuses on fixed nodes of a line or a closed surface, discretised by radial point interpolation."""
