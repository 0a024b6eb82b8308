"""Panels of plane problems."""

from types import SimpleNamespace

import numpy as np
import pytest

from pellucid.results.pictures.own import bodies_at
from pellucid.results.pictures.quantities import Look
from pellucid.results.pictures.style import house_style, settle
from pellucid.results.storage.stored_case import StoredBody


def two_points(height):
    """What pictures read of a run with a body of two points, four frames, no units of its own."""
    place = np.array([[0.0, 0.0, 0.0], [0.27, height, 0.0]])
    fields = {"position": place, "velocity": place, "mass": np.ones(2)}
    water = StoredBody("water", "material-points", "fluid", "tait", 1e3)
    stored = SimpleNamespace(bodies=[water], thin=(False, False, True), grid=None)
    cells = SimpleNamespace(lines=[])
    return SimpleNamespace(
        stored=stored,
        times=lambda name: np.arange(4.0),
        fields=lambda name, time=None, names=None: fields,
        cells=lambda name: cells,
    )


@pytest.mark.parametrize("height", [0.03, 0.09, 0.15, 0.27, 0.8])
def test_the_words_beside_the_axes_have_room(height):
    with house_style():
        figure = bodies_at(two_points(height), Look("speed"))
        settle(figure)
        figure.canvas.draw()
    boxes = [axes.yaxis.label.get_window_extent() for axes in figure.axes]
    assert min(box.x0 for box in boxes) >= 0.0
