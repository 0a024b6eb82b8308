"""Which columns of the history a report draws of itself."""

from tests.bags import case

import pellucid
from pellucid.results.pictures.figures import condition_columns, figures_of

PLOTTED = {"name": "curve", "x": "bag_volume", "y": "bag_pressure"}


def test_contents_of_a_membrane_are_drawn_that_change_and_no_plot_shows(tmp_path):
    held = {"gas": {"pressure": 2000.0, "temperature": 300.0}}
    bag = case(held, end=0.02, plot=[PLOTTED], output={"history": 0.002})
    run = pellucid.run(bag, out=tmp_path / "run", report=False)
    assert condition_columns(run) == ["bag_temperature"], "mass is constant, the others are plotted, gauge pressure as pressure"
    figure = figures_of(run, None, [])["conditions"]()
    assert [axes.get_ylabel() for axes in figure.axes] == ["bag temperature [K]"]
