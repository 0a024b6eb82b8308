"""Films of a run as animated GIF, which needs only pillow, a dependency of matplotlib."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pellucid.results.storage.drawn import drawing

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from PIL.Image import Image

FILM_DPI = 96
FRAME, HOLD = 120, 1500  # ms that a picture stays, and the last one
COLOURS = 256
NEARLY_WHITE = 244
SAMPLES = 6  # pictures whose pixels make the palette of the film; of more pictures it takes as many pixels, from each some
ALIKE = 8  # levels of a channel that are one colour as the palette is chosen
WEIGHT = 1.0 / 3.0  # power of the number of pixels with which a colour counts
ROUNDS = 3  # in which the palette moves to the means of what it stands for


class Animation(NamedTuple):
    """A film of a run: `draw(time)` returns the figure that shows the run at a time [s], `times` are the times of the
    pictures in order [s]. All figures have the same size."""

    draw: "Callable[[float], Figure]"
    times: Iterable[float]


def pixels_of(figure: "Figure") -> np.ndarray:
    """Return the RGB pixels of a figure, shape (rows, columns, 3)."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure.set_dpi(FILM_DPI)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[:, :, :3].copy()


def write_film(pictures: Sequence[np.ndarray], path: Path) -> None:
    """Write a film as animated GIF to `path`. pictures: RGB pixels of each frame, all of one shape (rows, columns, 3). Raises
    ValueError for a film without pictures."""
    from PIL.Image import Dither, fromarray

    if not pictures:
        raise ValueError("an animation requires at least one frame")
    images = [fromarray(picture) for picture in pictures]
    palette = _palette(images)
    # one palette and no dithering: what does not change between pictures is not stored again
    first, *others = [image.quantize(palette=palette, dither=Dither.NONE) for image in images]
    durations = [FRAME] * len(others) + [HOLD]
    with drawing(path) as temporary:
        first.save(temporary, format="GIF", save_all=True, append_images=others, duration=durations, loop=0)


def _palette(pictures: "list[Image]") -> "Image":
    """Return a colour table (an image with a palette) for all pictures of a film; a GIF has at most 256 colours.

    Mean colours would tint white areas; such colours are replaced by white. Each colour is weighted by a power of its number of
    pixels. If weighted by the number itself, the few pixels of a small hot spot would get no colour of their own.
    """
    from PIL.Image import Quantize, fromarray

    stride = -(-len(pictures) // SAMPLES)
    pixels = np.concatenate([np.asarray(picture).reshape(-1, 3)[k % stride :: stride] for k, picture in enumerate(pictures)])
    red, green, blue = (pixels // ALIKE).astype(np.int64).T
    levels = 256 // ALIKE
    which = (red * levels + green) * levels + blue
    count = np.bincount(which, minlength=levels**3)
    found = np.flatnonzero(count)
    count = count[found]
    means = np.stack([np.bincount(which, channel, levels**3)[found] / count for channel in pixels.T], axis=1)
    weighted = np.repeat(means.round().astype(np.uint8), np.rint(count**WEIGHT).astype(int), axis=0)
    palette = fromarray(weighted[None]).quantize(COLOURS, method=Quantize.MEDIANCUT, kmeans=ROUNDS)
    colours = np.reshape(palette.getpalette() or [], (-1, 3))
    colours[colours.min(axis=1) >= NEARLY_WHITE] = 255
    palette.putpalette(colours.ravel().tolist())
    return palette
