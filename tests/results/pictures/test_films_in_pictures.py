"""Fluid films in pictures: as surfaces that move, and as lines among the points of a fluid."""

import numpy as np
import pytest
from films import case
from matplotlib.colors import to_hex

import pellucid
from pellucid.results.pictures.bodies_in_space import SpaceStage
from pellucid.results.pictures.figures import figures_of
from pellucid.results.pictures.films import film_of
from pellucid.results.pictures.own import bodies_at
from pellucid.results.pictures.quantities import Look
from pellucid.results.pictures.style import house_style

SPHERE = "surface = {{ icosphere = {{ centre = [0, 0, 0], radius = 1, refinements = {} }} }}"
SQUEEZED = """
[[load]]
kind = "film-pressure"
body = "film"
value = -0.5
band = { axis = "z", width = 0.3 }
"""
IN_FLUID = """
schema = 1
title = "A film in a fluid"

[grid]
lower = [-2, -2, 0]
upper = [2, 2, 0]
cell = 0.5
functions = "quadratic-bspline"

[time]
end = 0.01

[[body]]
name = "film"
kind = "fluid-film"
shape = { ellipse = { radius = 1, nodes = 24 } }
material = { kind = "lipid-film", density = 900, viscosity = 0.05, stiffness = 4000 }

[[body]]
name = "fluid"
kind = "material-points"
shape = { box = { lower = [-2, -2, 0], upper = [2, 2, 0] } }
points_per_cell = [2, 2, 1]
material = { kind = "fluid", density = 1, viscosity = 1, eos = { kind = "tait", sound_speed = 20, carries_tension = true } }
initial = [{ kind = "velocity-gradient", x = [0, 1, 0] }]
"""


@pytest.fixture(scope="module")
def squeezed(tmp_path_factory):
    of = case(SPHERE.format(1), 0.3, 1.0, "", 'interpolation = "loop"', SQUEEZED)
    return pellucid.run(of, out=tmp_path_factory.mktemp("squeezed") / "run", report=False)


def test_a_surface_moves_with_its_density_and_its_flow(squeezed, monkeypatch):
    monkeypatch.setattr("pellucid.results.pictures.bodies_in_space.COLUMNS", 120)
    times = squeezed.times("film")
    with house_style():
        film = film_of(SpaceStage(squeezed, Look("load", arrows=True), times), times.tolist())
        figures = [film.draw(time) for time in film.times]
    pictures = [figure.axes[0].images[0].get_array() for figure in figures]
    assert pictures[0].shape == pictures[-1].shape
    assert not np.allclose(pictures[0], pictures[-1])
    assert figures[-1].axes[1].get_ylabel() == "surface density [kg/m²]"
    assert figures[0].axes[0].collections, "it has no inertia: it flows at once"
    (arrows,) = figures[-1].axes[0].collections
    strong = np.abs(arrows.V) > 0.3 * np.abs(arrows.V).max()
    assert strong.sum() > 5
    away = (arrows.V * arrows.Y > 0.0)[strong]
    assert away.mean() > 0.8, "the film flows away from the belt that squeezes it; seen from above, some places near it deceive"


def test_a_film_has_no_momentum_to_draw(squeezed):
    assert "momentum" not in figures_of(squeezed, None, [])


def test_a_film_in_a_fluid_is_a_dark_line_on_top(tmp_path):
    run = pellucid.run(pellucid.loads(IN_FLUID), out=tmp_path / "run", report=False)
    assert "momentum" in figures_of(run, None, [])
    with house_style():
        figure = bodies_at(run, Look("load"))
    dots, light, dark = figure.axes[0].collections
    assert len(dots.get_offsets()) == len(run.fields("fluid")["position"]), "the film is not among the dots"
    assert figure.axes[-1].get_ylabel().startswith("pressure"), "nor is its density among the pressures"
    assert len(dark.get_segments()) == 24
    assert dark.get_linewidth()[0] < light.get_linewidth()[0]
    assert max(dark.get_color()[0][:3]) < 0.3


def test_films_in_a_plane_have_a_colour_each_where_it_is_asked_for(tmp_path):
    case = pellucid.load("benet2015/compressed-vesicle").quick_variant().with_settings({"time.end": 0.01})
    run = pellucid.run(case, out=tmp_path / "run", report=False)
    with house_style():
        figure = bodies_at(run, Look("bodies"))
    names = [body.name for body in run.stored.bodies]
    curves = [drawn for drawn in figure.axes[0].collections if hasattr(drawn, "get_segments")]
    assert len({to_hex(drawn.get_color()[0]) for drawn in curves}) == len(names)
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == names
