"""Metrics and figures of a spherical blast, the same as those of a cylindrical blast."""

from pellucid.gallery.basics.blast import CAPTIONS, METRICS, figures, metrics

__all__ = ["CAPTIONS", "METRICS", "figures", "metrics"]
