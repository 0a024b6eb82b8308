"""The spherical blast is measured as the cylindrical one is."""

from pellucid.gallery.basics.blast import CAPTIONS, METRICS, figures, metrics

__all__ = ["CAPTIONS", "METRICS", "figures", "metrics"]
