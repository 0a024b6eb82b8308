import numpy as np
import pytest
import synthetic_oocyte

from pellucid.results.pictures.bodies_in_space import opening, panels_in_space
from pellucid.results.pictures.rendering.axes import round_length
from pellucid.results.pictures.style import house_style


def box(lower, upper):
    return np.random.default_rng(2).uniform(lower, upper, (50, 3)).clip(lower, upper)


def test_what_surrounds_another_body_is_opened_in_its_middle():
    outer, inner = box(0.0, 10.0), box(2.0, 6.0)
    plane = opening([outer, inner])
    middle = 0.5 * (inner.min(axis=0) + inner.max(axis=0))
    assert -0.01 < plane.beyond(middle[None])[0] < 0.0, "a layer in the middle stays"
    assert plane.beyond(middle[None] - [0.0, 1.0, 0.0]) == pytest.approx(1.0, abs=0.01), "the front goes"


def test_bodies_side_by_side_stay_whole():
    assert opening([box(0.0, 1.0), box(2.0, 3.0)]) is None
    assert opening([box(0.0, 1.0)]) is None


@pytest.mark.parametrize("quantity", ["speed", "load"])
def test_a_run_in_space_is_drawn(tmp_path, monkeypatch, quantity):
    monkeypatch.setattr("pellucid.results.pictures.bodies_in_space.COLUMNS", 150)
    run = synthetic_oocyte.write(tmp_path / "run", spacing=15.0, instants=2)
    with house_style():
        figure = panels_in_space(run, quantity)
    pictures = [axes.images[0].get_array() for axes in figure.axes if axes.images]
    assert len(pictures) == 2
    assert not np.allclose(*pictures)
    texts = [text.get_text() for text in figure.axes[1].texts]
    assert "t = 100 µs" in texts
    assert "cut open" in texts


@pytest.mark.parametrize(
    ("most", "length", "text"),
    [(2.7e-5, 2e-5, "20 µm"), (0.99e-3, 5e-4, "500 µm"), (1e-3, 1e-3, "1 mm"), (0.7, 0.5, "500 mm"), (30.0, 20.0, "20 m")],
)
def test_round_lengths(most, length, text):
    found, name = round_length(most)
    assert found == pytest.approx(length)
    assert name == text
