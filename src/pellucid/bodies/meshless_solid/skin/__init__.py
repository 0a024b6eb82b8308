"""The surface of a meshless solid, by which others touch it."""
