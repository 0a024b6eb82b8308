"""Pictures of runs that stopped themselves."""

import sys
import types
from pathlib import Path

import numpy as np
import pytest

from pellucid.errors import RunStopped
from pellucid.results import Run, run_case
from pellucid.results.pictures import figures
from pellucid.results.pictures.stopped import where_it_stopped

sys.path.insert(0, str(Path(__file__).parents[1]))
from free_flight import FakeSimulation, free_flight


@pytest.fixture
def stopped(tmp_path, monkeypatch):
    fake = types.SimpleNamespace(Simulation=FakeSimulation)
    monkeypatch.setitem(sys.modules, "pellucid.simulation.simulation", fake)
    monkeypatch.setattr(FakeSimulation, "breaks_at", 19)
    monkeypatch.setattr(FakeSimulation, "is_balanced", False)
    monkeypatch.setattr(FakeSimulation, "conservation", lambda sim: {"mass": 0.0, "momentum": 0.0, "energy": 0.03 * sim.time})
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
    assert {"limit of the warning", "stop"} <= {text.get_text() for text in figure.legends[0].get_texts()}
    assert not [text for axes in figure.axes for text in axes.texts]
    monkeypatch.setattr(figures, "FIRST_JUDGED", 200)  # not judged yet: no limit
    names = {text.get_text() for text in figures.energies(stopped).legends[0].get_texts()}
    assert "limit of the warning" not in names


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
    assert where_it_stopped(stopped).get_suptitle().startswith("Where the run stopped: step 42 of settling, ")
