"""Panels of plane problems."""

import numpy as np
import pytest

from pellucid.results.pictures.bodies_in_plane import _Flat
from pellucid.results.pictures.quantities import Limits
from pellucid.results.pictures.style import house_style, new_figure, settle


@pytest.mark.parametrize("height", [0.09, 0.114, 0.15])
@pytest.mark.parametrize("paper", [4.5, 5.0, 5.5, 6.0])
def test_the_words_beside_the_axes_have_room(height, paper):
    corners = np.array([[0.0, 0.0, 0.0], [0.27, height, 0.0]])
    flat = _Flat((False, False, True), [corners])
    with house_style():
        figure = new_figure(height=paper, layout="compressed")
        panels = figure.subplots(2, 2, sharex=True, sharey=True).ravel()
        for axes in panels:
            dots = flat.draw(axes, corners, np.array([0.0, 1.0]), 4.0, Limits(0.0, 1.0, "neither"))
            axes.set_title("t = 0 s")
        figure.colorbar(dots, ax=list(panels), aspect=25)
        settle(figure)
        figure.canvas.draw()
    boxes = [axes.yaxis.label.get_window_extent() for axes in panels]
    assert min(box.x0 for box in boxes) >= 0.0
