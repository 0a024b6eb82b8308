"""Profiles of a tube: the averages of points that lie exactly on the solution are the exact averages."""

from types import SimpleNamespace

import numpy as np
import pytest

from pellucid.case import load
from pellucid.gallery.gan2011.shock_tube import figures, metrics
from pellucid.references.gas_dynamics import Profile, Tube, points_of


class ExactRun:
    """What a run of a tube would leave if every point carried the exact solution."""

    def __init__(self, case, per_cell=40):
        self.case, self.tube, self.time = case, Tube.of(case), case.time.end
        n = per_cell * round((self.tube.upper - self.tube.lower) / self.tube.cell)
        x = self.tube.lower + (np.arange(n) + 0.5) * (self.tube.upper - self.tube.lower) / n
        exact = self.tube.exact(x, self.time)
        contact = self.tube.fronts(self.time)["contact"]
        self.frames = {}
        for body, side in zip(case.body, (x < contact, x >= contact), strict=True):
            frame = {name: values[side] for name, values in exact.items()}
            frame["mass"] = frame["density"] * (x[1] - x[0])
            frame["position"] = np.column_stack([x[side], 0 * x[side], 0 * x[side]])
            frame["velocity"] = np.column_stack([frame["velocity"], 0 * x[side], 0 * x[side]])
            self.frames[body.name] = frame
        self.summary = SimpleNamespace()

    def times(self, body):
        return np.array([0.0, self.time])

    def fields(self, body, time=None):
        return self.frames[body]


CHANGES = {
    "paper": {},
    "Sod": {"body.driven.material.pressure": 0.1, "time.end": 0.2},
    "strong, other gamma": {
        "body.driver.material.pressure": 10.0,
        "body.driven.material.density": 0.02,
        "body.driver.material.eos.gamma": 1.6667,
        "body.driven.material.eos.gamma": 1.6667,
        "time.end": 0.04,
    },
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_an_exact_run_has_no_error(change):
    run = ExactRun(load("gan2011/shock-tube").with_settings(change))
    found = metrics(run)
    for name, metric in found.items():
        assert metric.passed, (name, metric)
    assert found["density_l1"].value < 2e-4  # points stand for a fortieth of a cell, and the fronts cut through one


def test_points_of_the_paper_are_judged_as_means_are():
    for change, limit in (({}, 0.78), ({"grid.cell": 0.005, "time.step": 8e-5}, 1.25 * 0.729825)):
        metric = metrics(ExactRun(load("gan2011/shock-tube").with_settings(change)))["densest_point"]
        assert metric.reference * (1.0 + metric.tolerance) == pytest.approx(limit, rel=1e-5)


def test_means_are_conservative():
    run = ExactRun(load("gan2011/shock-tube"))
    tube, points = run.tube, points_of(run)
    profile = Profile.of_points(points, tube.edges(4))
    width = np.diff(profile.edges)
    assert np.sum(profile.means["density"] * width) == pytest.approx(points["mass"].sum(), rel=1e-3)
    momentum = np.sum(profile.means["density"] * profile.means["velocity"] * width)
    assert momentum == pytest.approx(np.sum(points["mass"] * points["velocity"][:, 0]), rel=1e-3)


def test_a_displaced_profile_is_within_the_bound_of_its_variation():
    tube = Tube.of(load("gan2011/shock-tube"))
    exact = tube.mean_profile(0.143)
    for cells in (4, 8):  # whole bins
        moved = Profile(exact.edges, {name: np.roll(means, cells // 4) for name, means in exact.means.items()})
        for means in moved.means.values():
            means[: cells // 4] = means[cells // 4]
        error = moved.relative_l1(exact, "density")
        assert 0 < error <= cells * tube.cell * exact.relative_variation("density") * (1 + 1e-9)


def test_an_empty_bin_is_left_out():
    points = {name: np.ones(3) for name in ("density", "pressure", "internal_energy", "mass")}
    points["position"] = points["velocity"] = np.array([[0.1, 0, 0], [0.2, 0, 0], [0.9, 0, 0]])
    profile = Profile.of_points(points, np.linspace(0, 1, 4))
    assert np.isnan(profile.means["density"][1])
    assert np.isfinite(profile.relative_l1(Profile(profile.edges, {"density": np.ones(3)}), "density"))


def test_solids_have_no_riemann_problem():
    with pytest.raises(ValueError, match="ideal gas"):
        Tube.of(load("basics/colliding-discs"))


def test_the_start_is_the_two_gases():
    """As of a run that stopped while its bodies settled: there is no shock yet to be shown close up."""
    run = ExactRun(load("basics/sod"))
    exact = run.tube.exact(np.array([0.1, 0.4, 0.5, 0.6]), 0.0)  # the diaphragm is one of the places
    assert exact["density"].tolist() == [1.0, 1.0, 0.125, 0.125]
    assert exact["pressure"].tolist() == pytest.approx([1.0, 1.0, 0.1, 0.1])
    run.time = 0.0
    assert set(figures(run)) == {"profiles"}


def test_figures_are_drawn():
    assert set(figures(ExactRun(load("gan2011/shock-tube")))) == {"profiles", "shock"}
