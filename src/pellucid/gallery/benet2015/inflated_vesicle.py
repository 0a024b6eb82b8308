"""Inflated vesicle against the exact motion."""

from pellucid.gallery.benet2015.growing import CAPTIONS, METRICS, figures, films, metrics

__all__ = ["CAPTIONS", "METRICS", "figures", "films", "metrics"]
