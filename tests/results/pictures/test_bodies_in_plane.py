"""Panels of plane problems."""

from types import SimpleNamespace

import numpy as np
import pytest

from pellucid.results.pictures.own import bodies_at
from pellucid.results.pictures.quantities import Look
from pellucid.results.pictures.style import house_style, settle
from pellucid.results.storage.run_folder import StoredBody, StoredWall


def two_points(height, walls=()):
    """What pictures read of a run with a body of two points, four frames, no units of its own."""
    place = np.array([[0.0, 0.0, 0.0], [0.27, height, 0.0]])
    fields = {"position": place, "velocity": place, "mass": np.ones(2)}
    water = StoredBody("water", "material-points", "fluid", "tait", 1e3)
    stored = SimpleNamespace(bodies=[water], thin=(False, False, True), grid=None, walls=walls)
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


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_wall_is_a_line_with_hatches_behind_it(way):
    """It rises at 0.01 m/s; pictures are of 0, 1, 2 and 3 s."""
    normal = np.array([0.6, 0.8, 0.0])
    wall = StoredWall("wall 1", np.array([0.1, 0.1, 0.0]), way * normal, 0.01 * normal)
    with house_style():
        figure = bodies_at(two_points(0.27, [wall]), Look("speed"))
    panels = [axes for axes in figure.axes if axes.lines]
    assert len(panels) > 1
    for time, axes in zip((0.0, 3.0), (panels[0], panels[-1]), strict=True):
        ends, (band,) = axes.lines[0].get_xydata(), axes.patches
        assert ends @ normal[:2] == pytest.approx(0.14 + 0.01 * time, abs=1e-12)
        height = way * (band.get_xy() @ normal[:2] - 0.14 - 0.01 * time)
        assert height.max() < 1e-12
        assert height.min() > -0.02
        assert band.get_hatch()
