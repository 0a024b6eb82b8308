"""Metrics and figures of compressed vesicles of three viscosities, compared with the exact motion."""

from pellucid.gallery.benet2015 import growing
from pellucid.gallery.benet2015.growing import figures, metrics

CAPTIONS = {"growth": "Radius, density and speed of the films against time, compared with the exact solution."}

METRICS = (*growing.METRICS, *(f"{name}-{film}" for film in ("less-viscous", "more-viscous") for name in ("radius", "density")))

__all__ = ["CAPTIONS", "METRICS", "figures", "metrics"]
