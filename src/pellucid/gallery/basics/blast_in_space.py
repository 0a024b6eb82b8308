"""Metrics and figures of a spherical blast: those of the cylindrical one."""

from pellucid.gallery.basics.blast import CAPTIONS, METRICS, figures, metrics

__all__ = ["CAPTIONS", "METRICS", "figures", "metrics"]
