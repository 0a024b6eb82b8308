"""Display of a rendered picture on the axes of a figure: colours of values, scale bar, texts in the corners."""

from typing import Any

import numpy as np

from pellucid.results.pictures.annotations import Axes
from pellucid.results.pictures.rendering.camera import Camera

LENGTHS = ((1.0, "m"), (1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm"))
INK = "#222233"
UNCOLOURED = "#c4c8d0"
"""Colour of points without a value."""


def coloured(values: np.ndarray, limits: tuple[float, float], palette: str) -> np.ndarray:
    """Return the RGB colours of values, shape (*values.shape, 3); NaN where a value is NaN or infinite.

    limits: the values that have the first and the last colour of the colour map `palette`.
    """
    from matplotlib import colormaps

    low, high = limits
    known = np.isfinite(values)
    found = np.full((*values.shape, 3), np.nan)
    found[known] = colormaps[palette](np.clip((values[known] - low) / (high - low), 0.0, 1.0))[:, :3]
    return found


def show(axes: Axes, picture: np.ndarray, camera: Camera) -> None:
    """Show a rendered picture (RGBA, lowest row first) on axes, with coordinates in metres, without ticks and frame."""
    (left, low), (right, high) = camera.low, camera.high
    axes.imshow(picture, origin="lower", extent=(left, right, low, high), interpolation="antialiased")
    axes.set_axis_off()


def scale_bar(axes: Axes, camera: Camera) -> None:
    """Draw a scale bar of a round length in the lower right corner. The projection is parallel, so lengths normal to the
    line of sight are true."""
    length, text = round_length(0.22 * float((camera.high - camera.low)[0]))
    size = float((camera.high - camera.low).max())
    x, y = camera.high[0] - 0.02 * size - length, camera.low[1] + 0.02 * size
    axes.plot([x, x + length], [y, y], color=INK, linewidth=2.2, solid_capstyle="butt")
    _word(axes, x + 0.5 * length, y + 0.012 * size, text, ha="center", va="bottom", fontsize=8.5, color=INK)


def round_length(most: float) -> tuple[float, str]:
    """Return the largest length [m] of 1, 2 or 5 times a power of ten that is at most `most` [m], and its text, e.g. (2e-5, "20
    µm")."""
    power = 10.0 ** np.floor(np.log10(most))
    length = max(step * power for step in (1.0, 2.0, 5.0) if step * power <= most * (1.0 + 1e-9))
    unit, name = next((pair for pair in LENGTHS if length >= 0.999 * pair[0]), LENGTHS[-1])
    return float(length), f"{length / unit:.3g} {name}"


def corner_words(axes: Axes, left: str, right: str, colour: str = INK) -> None:
    """Write texts in the upper corners: the left one in bold, the right one in the given colour."""
    _word(axes, 0.005, 1.0, left, transform=axes.transAxes, va="top", fontsize=11, fontweight="bold", color=INK)
    _word(axes, 0.995, 0.995, right, transform=axes.transAxes, va="top", ha="right", fontsize=8.5, color=colour)


def _word(axes: Axes, x: float, y: float, text: str, **look: Any) -> None:
    from matplotlib.patheffects import withStroke

    axes.text(x, y, text, path_effects=[withStroke(linewidth=3.0, foreground="white")], **look)
