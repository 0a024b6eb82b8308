"""Metrics and figures of a translating vesicle, compared with the exact steady motion."""

from pellucid.gallery.benet2015.translating import CAPTIONS, METRICS, figures, metrics

__all__ = ["CAPTIONS", "METRICS", "figures", "metrics"]
