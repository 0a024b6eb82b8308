"""Translating sphere against the exact steady motion."""

from pellucid.gallery.benet2015.translating import METRICS, figures, metrics

CAPTIONS = {"translation": "Velocity against time, and at the end the tension along the axis of motion, with the exact ones."}

__all__ = ["CAPTIONS", "METRICS", "figures", "metrics"]
