"""Types for annotations in pictures and the gallery.

Matplotlib is slow to import and is therefore imported only in functions that draw.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pellucid.results.storage.run import Run
else:
    Axes = Figure = Run = object

__all__ = ["Axes", "Figure", "Run"]
