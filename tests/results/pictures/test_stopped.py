"""Pictures of runs that stopped themselves."""

import sys

import numpy as np
import pytest
from free_flight import FakeBudget, FakeSimulation, fake_module, free_flight

from pellucid.errors import RunStopped
from pellucid.results.pictures import figures
from pellucid.results.pictures.stopped import where_it_stopped
from pellucid.results.storage.run import Run
from pellucid.running.launch import run_case


@pytest.fixture
def stopped(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pellucid.simulation.simulation", fake_module())
    monkeypatch.setattr(FakeSimulation, "breaks_at", 19)
    monkeypatch.setattr(FakeBudget, "is_complete", False)
    errors = {"mass": 0.0, "momentum": 0.0}
    monkeypatch.setattr(FakeBudget, "conservation", lambda budget: errors | {"energy": 0.03 * budget._simulation.time})
    with pytest.raises(RunStopped):
        run_case(free_flight(), tmp_path / "run", report=False)
    return Run(tmp_path / "run")


def test_the_ring_is_whole_at_an_edge_and_the_legend_hides_no_point(stopped):
    figure = where_it_stopped(stopped)
    rings = [line for axes in figure.axes for line in axes.lines if line.get_markersize() > 10]
    assert len(rings) == 2
    assert not any(ring.get_clip_on() for ring in rings)
    assert all(axes.get_legend() is None for axes in figure.axes)
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["gas", "block"]


def test_the_limit_and_the_stop_are_in_the_legend(stopped, monkeypatch):
    monkeypatch.setattr(figures, "FIRST_JUDGED", 5)
    figure = figures.energies(stopped)
    assert {"warning limit", "stop"} <= {text.get_text() for text in figure.legends[0].get_texts()}
    assert not [text for axes in figure.axes for text in axes.texts]
    monkeypatch.setattr(figures, "FIRST_JUDGED", 200)  # not judged yet: no limit
    names = {text.get_text() for text in figures.energies(stopped).legends[0].get_texts()}
    assert "warning limit" not in names


def test_curves_of_a_single_row_can_be_told_apart(stopped):
    row = {name: values[:1].copy() for name, values in stopped.history.items()}
    energies = [name for name in row if stopped.units[name] == "J"]
    row |= {f"{number}_work": np.ones(1) for number in range(10)}
    stopped.history, stopped.units = row, stopped.units | {f"{number}_work": "J" for number in range(10)}
    lines = figures.energies(stopped).axes[0].lines
    curves = [line for line in lines if line.get_label() != "stop"]
    assert len(curves) > 10 >= len(energies)
    assert len({(line.get_color(), line.get_marker()) for line in curves}) == len(curves)


def test_the_title_names_the_step_of_the_run_or_of_settling(stopped, monkeypatch):
    assert where_it_stopped(stopped).get_suptitle().startswith("Where the run stopped: step 19, ")
    monkeypatch.setattr(Run, "stopped", stopped.stopped | {"settling_step": 42})
    assert where_it_stopped(stopped).get_suptitle().startswith("Where the run stopped: settling step 42, ")


def test_the_edge_of_the_grid_is_drawn_about_a_point_that_left_it(stopped, monkeypatch):
    close_up = where_it_stopped(stopped).axes[1]
    assert not close_up.patches  # far within it
    for beyond in (1e-3, 1.5):
        monkeypatch.setattr(Run, "stopped", stopped.stopped | {"position": [4.0 + beyond, 1.0, 0.25]})
        figure = where_it_stopped(stopped)
        (edge,) = figure.axes[1].patches
        assert edge.get_bbox().get_points().tolist() == [[0.0, 0.0], [4.0, 2.0]]
        assert figure.axes[1].get_xlim()[0] < 4.0
        assert "boundary of the grid" in {text.get_text() for text in figure.legends[0].get_texts()}


def test_of_energies_stored_before_the_start_the_change_is_shown(stopped):
    strain = stopped.history["strain_energy"]
    stopped.history = stopped.history | {"strain_energy": 5.0 + strain}
    curves = {line.get_label(): line.get_ydata() for line in figures.energies(stopped).axes[0].lines}
    assert "strain" not in curves
    np.testing.assert_allclose(curves["change of strain"], strain - strain[0], atol=1e-14)


def test_entries_too_small_to_be_seen_are_told_and_curves_beneath_others_seen(stopped):
    kinetic = stopped.history["kinetic_energy"]
    stopped.history = stopped.history | {"load_work": 2e-4 * kinetic, "motion_work": kinetic}
    stopped.units = stopped.units | {"load_work": "J", "motion_work": "J"}
    figure = figures.energies(stopped)
    widths = {line.get_label(): line.get_linewidth() for line in figure.axes[0].lines}
    assert "load work" not in widths
    assert "load\u00a0work" in figure.legends[0].get_title().get_text()
    assert widths["motion work"] < 0.6 * widths["kinetic"]
    often = np.where(np.arange(len(kinetic)) % 2, 1.0, -1.0) * kinetic.max()
    repeated = {name: np.tile(values, 20) for name, values in stopped.history.items()}
    stopped.history = repeated | {"motion_work": np.tile(often, 20)}
    crowded = {line.get_label(): line.get_linewidth() for line in figures.energies(stopped).axes[0].lines}
    assert crowded["kinetic"] < 0.6 * widths["kinetic"]
