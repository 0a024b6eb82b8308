"""Inflated vesicle against the exact motion."""

from pellucid.gallery.benet2015.growing import METRICS, figures, films, metrics

CAPTIONS = {"growth": "Radius, density and speed of the film against time, with the exact ones."}

__all__ = ["CAPTIONS", "METRICS", "figures", "films", "metrics"]
