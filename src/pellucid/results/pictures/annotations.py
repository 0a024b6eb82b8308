"""Types that pictures and the gallery annotate. Matplotlib is heavy, and imported where something is drawn."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pellucid.results.storage.run import Run
else:
    Axes = Figure = Run = object

__all__ = ["Axes", "Figure", "Run"]
