"""Regions of space that bodies fill: balls, boxes, cylinders and other shapes of a case."""
