"""Sod's tube is measured as any other tube is."""

from pellucid.gallery.gan2011.shock_tube import METRICS, figures, metrics

__all__ = ["METRICS", "figures", "metrics"]
