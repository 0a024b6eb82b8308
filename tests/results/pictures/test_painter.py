"""Pictures drawn here and in helpers: the same."""

import numpy as np
import pytest

from pellucid.case import load
from pellucid.progress import QuietProgress
from pellucid.results.pictures import painter
from pellucid.results.pictures.style import house_style, new_figure, settle
from pellucid.running.launch import run_case
from pellucid.system.processes import Helper


@pytest.fixture(scope="module")
def wave(tmp_path_factory):
    case = load("basics/elastic-wave").quick_variant()
    return run_case(case, tmp_path_factory.mktemp("wave") / "run", until=0.1, report=False)


class Told(QuietProgress):
    def __init__(self):
        super().__init__()
        self.told = []

    def begin(self, phase, total=None):
        self.told.append((phase, total))

    def count(self, done):
        self.told.append(done)


def written(run, monkeypatch, helpers):
    begun = []

    class Counted(Helper):
        def __init__(self, make, *arguments):
            super().__init__(make, *arguments)
            begun.append(self)

    monkeypatch.setattr(painter, "Helper", Counted)
    monkeypatch.setattr(painter, "free_cores", lambda: helpers)
    monkeypatch.setattr(painter, "MANY_POINTS", {True: 0, False: 0})
    progress, notices = Told(), []
    titles = painter.write_pictures(run, None, progress, notices)
    assert len(begun) == helpers
    assert all(helper._process.returncode is not None for helper in begun)
    assert not notices
    assert progress.told[-1] == len(titles)
    return {path.name: path.read_bytes() for path in titles}


def test_all_pictures_are_written_and_helpers_end(wave, monkeypatch):
    pictures = written(wave, monkeypatch, 1)
    assert {"energies.png", "momentum.png", "probes.png"} < pictures.keys()
    assert all(data.startswith(b"\x89PNG") for data in pictures.values())


def test_a_helper_draws_what_this_process_draws(wave):
    own = painter.Painter(wave)
    helper = Helper(painter._draw_in, wave.out, None)
    try:
        assert helper.ask("momentum") == own.draw("momentum")
    finally:
        helper.end()


def test_small_runs_are_drawn_without_helpers(wave, monkeypatch):
    monkeypatch.setattr(painter, "Helper", lambda *arguments: pytest.fail("a process began"))
    monkeypatch.setattr(painter, "free_cores", lambda: 4)
    assert painter.drawing_helpers(wave) == []


def test_helpers_that_began_before_are_used_and_end(wave, monkeypatch):
    monkeypatch.setattr(painter, "MANY_POINTS", {True: 0, False: 0})
    monkeypatch.setattr(painter, "free_cores", lambda: 1)
    helpers = painter.drawing_helpers(wave)
    monkeypatch.setattr(painter, "drawing_helpers", lambda *runs: pytest.fail("others began"))
    assert painter.write_pictures(wave, None, Told(), [], helpers)
    assert [helper._process.returncode is not None for helper in helpers] == [True]


def test_layouts_settle_once(wave):
    with house_style():
        figure = painter.figures.energies(wave)
        settle(figure)
        before = [axes.get_position().bounds for axes in figure.axes]
        figure.draw_without_rendering()
    assert before == [axes.get_position().bounds for axes in figure.axes]
    assert len(before) == 2
    assert before[0][0] + before[0][2] < before[1][0], "beside each other"


def test_a_figure_without_axes_is_drawn_without_a_warning(recwarn):
    assert painter.figures.picture_of(new_figure(1.0, 1.0)).data.startswith(b"\x89PNG")
    assert not recwarn.list


def test_a_film_whose_pictures_cannot_all_be_drawn_is_left_out(wave, monkeypatch):
    from pellucid.results.pictures.films import Animation
    from pellucid.results.storage.files import OutputError

    def draw(time):
        if time > 0.0:
            raise OutputError("a file is damaged")
        return new_figure(1.0, 1.0)

    monkeypatch.setattr(painter, "drawn_by_module", lambda run, kind: {"wave": Animation(draw, (0.0, 1.0))})
    monkeypatch.setattr(painter.figures, "figures_of", lambda run, beside, notices: {"still": lambda: new_figure(1.0, 1.0)})
    notices = []
    assert [path.name for path in painter.write_pictures(wave, None, Told(), notices)] == ["still.png"]
    assert notices == ["a file is damaged"]
    assert np.asarray(painter.Painter(wave).draw(painter.FilmPicture("wave", 0.0))).shape == (96, 96, 3)
