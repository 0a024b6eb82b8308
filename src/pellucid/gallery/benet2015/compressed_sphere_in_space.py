"""Compressed sphere in space against the exact motion."""

from pellucid.gallery.benet2015.growing import METRICS, figures, metrics

CAPTIONS = {"growth": "Radius, density and speed of the film against time, with the exact ones."}

__all__ = ["CAPTIONS", "METRICS", "figures", "metrics"]
