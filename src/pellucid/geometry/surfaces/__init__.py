"""Surfaces that membranes and films lie on, as cases describe them, and the meshes that are made of them."""
