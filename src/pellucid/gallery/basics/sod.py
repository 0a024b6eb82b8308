"""Sod's tube is measured as any other tube is."""

from pellucid.gallery.gan2011.shock_tube import figures, metrics

__all__ = ["figures", "metrics"]
