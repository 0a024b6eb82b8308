"""Metrics and figures of Sod's shock tube, the same as those of all shock tubes."""

from pellucid.gallery.gan2011.shock_tube import METRICS, figures, metrics

__all__ = ["METRICS", "figures", "metrics"]
