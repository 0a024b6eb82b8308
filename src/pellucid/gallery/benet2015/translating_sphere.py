"""Translating sphere against the exact steady motion."""

from pellucid.gallery.benet2015.translating import METRICS, figures, metrics

CAPTIONS = {"translation": "Error of the velocity against time, and at the end the tension along the axis of motion, with the exact one."}

__all__ = ["CAPTIONS", "METRICS", "figures", "metrics"]
