"""Regions of space that bodies fill: balls, boxes, cylinders and more, as cases describe them."""
