"""A concentration that diffuses on fixed nodes of a line or a closed surface, by radial point interpolation."""
