"""Metrics and figures of an inflated vesicle, compared with the exact motion."""

from pellucid.gallery.benet2015.growing import CAPTIONS, METRICS, figures, metrics

__all__ = ["CAPTIONS", "METRICS", "figures", "metrics"]
