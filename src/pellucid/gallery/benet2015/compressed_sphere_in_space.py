"""Metrics and figures of a compressed sphere in space, compared with the exact motion."""

from pellucid.gallery.benet2015.growing import CAPTIONS, METRICS, figures, metrics

__all__ = ["CAPTIONS", "METRICS", "figures", "metrics"]
