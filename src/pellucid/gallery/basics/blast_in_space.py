"""Spherical blast, with the same metrics as the cylindrical one."""

from pellucid.gallery.basics.blast import CAPTIONS, METRICS, figures, metrics

__all__ = ["CAPTIONS", "METRICS", "figures", "metrics"]
