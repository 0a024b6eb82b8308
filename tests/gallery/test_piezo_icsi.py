import numpy as np
import pytest
import synthetic_oocyte

from pellucid.gallery.gan2011 import piezo_icsi
from pellucid.results.pictures.films import pixels_of
from pellucid.results.pictures.style import house_style


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return synthetic_oocyte.write(tmp_path_factory.mktemp("oocyte"), refinements=4, spacing=15.0, instants=5)


def red_pixels(run, time, stage):
    from pellucid.results.pictures.style import new_figure

    figure = new_figure(4.0, 4.0)
    axes = figure.subplots()
    piezo_icsi.draw_oocyte(axes, run, time, stage)
    picture = axes.images[0].get_array()
    return int(((picture[:, :, 0] > 2.5 * picture[:, :, 1:3].max(axis=2)) & (picture[:, :, 3] > 0)).sum())


@pytest.mark.parametrize("view", ["whole", "cut"])
def test_failed_parts_are_red_and_nothing_else_is(run, view):
    times = run.times("zona")
    stage = piezo_icsi.whole_stage(run, 300) if view == "whole" else piezo_icsi.cut_stage(run, 300, times)
    assert run.fields("zona", 0.0)["failed"].sum() == 0
    assert red_pixels(run, 0.0, stage) == 0
    assert run.fields("zona", 100e-6)["failed"].sum() > 0
    assert red_pixels(run, 100e-6, stage) > 20


def test_the_cut_shows_the_pressure_at_the_contact(run):
    stage = piezo_icsi.cut_stage(run, 300, run.times("zona"))
    pressure = run.fields("cytoplasm", 50e-6)["pressure"]
    assert stage.limits[1] > 0.5 * np.abs(pressure).max()


def test_pictures_of_the_film_do_not_depend_on_those_drawn_before(run, monkeypatch):
    monkeypatch.setattr(piezo_icsi, "FILM_COLUMNS", 100)
    with house_style():
        films = [piezo_icsi.films(run)["oocyte"] for _ in range(2)]
        early, late, again = (pixels_of(films[0].draw(time)) for time in (0.0, 100e-6, 0.0))
        alone = pixels_of(films[1].draw(100e-6))
    assert np.array_equal(early, again)
    assert np.array_equal(late, alone)
    assert not np.array_equal(early, late)


def test_figures_and_film_can_be_drawn(run, monkeypatch):
    monkeypatch.setattr(piezo_icsi, "COLUMNS", 200)
    monkeypatch.setattr(piezo_icsi, "FILM_COLUMNS", 150)
    with house_style():
        figures = {name: draw() for name, draw in piezo_icsi.oocyte_figures(run).items()}
        film = piezo_icsi.films(run)["oocyte"]
        picture = film.draw(next(iter(film.times)))
    assert [len([axes for axes in figure.axes if axes.images]) for figure in (*figures.values(), picture)] == [4, 4, 2]
    assert figures.keys() | {"oocyte"} == piezo_icsi.OOCYTE_CAPTIONS.keys()
    assert list(film.times) == pytest.approx(run.times("zona").tolist())
