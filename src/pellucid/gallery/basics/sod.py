"""Sod's shock tube, with the metrics of all shock tubes."""

from pellucid.gallery.gan2011.shock_tube import METRICS, figures, metrics

__all__ = ["METRICS", "figures", "metrics"]
