import numpy as np
import pytest
from PIL import Image

from pellucid.results.pictures.films import FILM_DPI, HOLD, pixels_of, write_film
from pellucid.results.pictures.style import new_figure

TIMES = (0.0, 0.5, 1.0)


def draw(time):
    figure = new_figure(2.0, 1.0)
    axes = figure.subplots()
    axes.set_axis_off()
    axes.imshow(np.array([[[1.0, 0.0, 0.0]]]), extent=(time, time + 0.5, 0.0, 1.0))
    axes.set_xlim(-0.2, 2.0)
    return figure


@pytest.fixture
def film(tmp_path):
    path = tmp_path / "red.gif"
    write_film([pixels_of(draw(time)) for time in TIMES], path)
    with Image.open(path) as found:
        yield found


def test_a_film_has_its_pictures_and_holds_the_last(film):
    assert film.n_frames == len(TIMES)
    durations = []
    for k in range(film.n_frames):
        film.seek(k)
        durations.append(film.info["duration"])
    assert durations[-1] == HOLD > durations[0] == durations[1]


def test_colours_stay_and_things_move(film):
    middles = []
    for k in range(film.n_frames):
        film.seek(k)
        picture = np.asarray(film.convert("RGB")).astype(int)
        assert tuple(picture[0, 0]) == (255, 255, 255)
        red = (picture[:, :, 0] > 240) & (picture[:, :, 1:] < 15).all(axis=2)
        middles.append(np.nonzero(red)[1].mean())
    assert middles[0] < middles[1] < middles[2]


def test_a_small_spot_of_orange_does_not_take_the_red_of_something_large(tmp_path):
    """Most of the picture is shades of teal and red, as failed parts are; a hot spot is 4 pixels of 30 000."""
    shade = np.linspace(0.4, 1.0, 200)[:, None]
    picture = np.concatenate(
        [shade[:, None] * np.array(hue) * np.ones((200, 75, 1)) for hue in ((0.36, 0.76, 0.77), (0.92, 0.1, 0.09))], axis=1
    )
    picture[20:22, 20:22] = (0.89, 0.52, 0.08)

    def draw_spot(time):
        figure = new_figure()
        figure.set_dpi(FILM_DPI)
        figure.figimage(picture, origin="upper", resize=True)
        return figure

    write_film([pixels_of(draw_spot(time)) for time in TIMES], tmp_path / "spot.gif")
    with Image.open(tmp_path / "spot.gif") as found:
        shown = np.asarray(found.convert("RGB")).astype(float) / 255.0
    spot = np.argwhere(np.abs(shown - (0.89, 0.52, 0.08)).max(axis=2) < 0.06)
    assert len(spot) == 4
    assert np.abs(shown - picture).max() < 0.15


def test_a_film_needs_pictures(tmp_path):
    with pytest.raises(ValueError, match="at least one frame"):
        write_film([], tmp_path / "none.gif")
