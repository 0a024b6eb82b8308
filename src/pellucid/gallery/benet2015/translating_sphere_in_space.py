"""Translating sphere in space against the exact steady motion."""

from pellucid.gallery.benet2015.translating import METRICS, figures, metrics

CAPTIONS = {
    "translation": "Error of the velocity against time, and the tension along the axis of motion at its end and the exact one."
}

__all__ = ["CAPTIONS", "METRICS", "figures", "metrics"]
