"""Metrics of a vesicle in space: its bending energy, compared with the solution of the shape equations."""

from pellucid.gallery.benet2015.vesicle_shapes import metrics

__all__ = ["METRICS", "metrics"]

METRICS = ("prolate-90",)
