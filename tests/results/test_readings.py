"""Columns read as curves: reactions are means since the row before, and compared where they hold."""

import csv

import numpy as np
import pytest

import pellucid
from pellucid.case import Case
from pellucid.case.judgement import Check
from pellucid.results.metrics import Readings, mean_columns, metric_of
from pellucid.studies.misfit import read_curve

LAG, AT_START = 0.05, 0.8
"""Relaxation time [s] of the exact curve, and the share that relaxes."""
EDGE, SHEAR, MODULUS, RISE = 0.01, 1e-3, 8e3, 0.004
HISTORY = 5e-3
"""A tenth of the relaxation time: means at the ends of their intervals are up to 5 % off, in their middles (h/τ)²/24 = 4e-4."""


def relaxing(times):
    return 1.0 + AT_START * np.exp(-times / LAG)


def mean_of_relaxing(start, end):
    return 1.0 - AT_START * LAG * (np.exp(-end / LAG) - np.exp(-start / LAG)) / (end - start)


@pytest.fixture
def history():
    """Rows at uneven instants: the exact means since the row before, zero in the first row, and the way, momentary."""
    times = np.concatenate([[0.0], np.cumsum(np.tile([0.004, 0.006], 15))])
    return {"time": times, "force": np.concatenate([[0.0], mean_of_relaxing(times[:-1], times[1:])]), "way": 3.0 * times}


def test_a_mean_holds_in_the_middle_of_its_interval(history):
    times, force = Readings(history, ["force"]).curve("force")
    np.testing.assert_allclose(times, 0.5 * (history["time"][1:] + history["time"][:-1]))
    assert np.abs(force / relaxing(times) - 1.0).max() < (0.006 / LAG) ** 2 / 24.0
    assert np.abs(force / relaxing(history["time"][1:]) - 1.0).max() > 0.02, "that of the end of the interval is 2 % off"


def test_two_columns_are_read_at_the_same_instants(history):
    way, force = Readings(history, ["force"]).curve("force", "way")
    assert np.abs(force / relaxing(way / 3.0) - 1.0).max() < (0.006 / LAG) ** 2 / 24.0
    np.testing.assert_allclose(Readings(history, ["force"]).curve("way", "force")[1], way)


def test_momentary_columns_stay_as_they_are(history):
    x, y = Readings(history, ["force"]).curve("way")
    assert x is history["time"]
    assert y is history["way"]


def test_between_and_beyond_the_middles_means_are_continued(history):
    readings, at = Readings(history, ["force"]), np.linspace(0.0, 0.15, 61)
    # linear between instants h apart, and over half an interval at the ends: h²/8 and 3h²/8 of the second derivative
    assert np.abs(readings.at("force", at) - relaxing(at)).max() < 0.5 * AT_START * (0.006 / LAG) ** 2
    assert np.isnan(readings.at("force", 0.151))
    few = Readings({name: values[:1] for name, values in history.items()}, ["force"])
    assert few.curve("force")[1] == [0.0]
    two = Readings({name: values[:2] for name, values in history.items()}, ["force"])
    np.testing.assert_allclose(two.curve("force", whole=True)[1], history["force"][1])


@pytest.mark.parametrize(
    ("asked", "right"),
    [
        ({"at": 0.05}, relaxing(0.05)),
        ({"when": {"column": "way", "reaches": 0.15}}, relaxing(0.05)),
        ({"take": "smallest"}, None),
    ],
)
def test_a_check_reads_a_mean_where_it_holds(history, asked, right):
    exact = relaxing(0.148) if right is None else right
    check = Check(name="a", column="force", reference=float(exact), relative_tolerance=2e-3, source="exact", **asked)
    units = {"time": "s", "force": "N", "way": "m"}
    found = metric_of(check, Readings(history, ["force"]), units)
    assert found.passed, found
    assert not metric_of(check, Readings(history), units).passed


def test_between_a_few_equilibria_a_spline_is_read():
    """Exact for a cubic; straight lines are off by up to h²/8 of the second derivative."""
    times = np.linspace(0.0, 1.0, 5)
    history = {"time": times, "force": times**3, "way": 2.0 * times}
    at = np.linspace(0.0, 1.0, 23)
    steady, moving = Readings(history, is_steady=True), Readings(history)
    assert np.abs(steady.at("force", at) - at**3).max() < 1e-15
    assert np.abs(moving.at("force", at) - at**3).max() > 0.03
    np.testing.assert_array_equal(steady.at("force", times), history["force"])
    assert steady.first_time("force", 0.6**3) == pytest.approx(0.6, abs=1e-12)
    assert moving.first_time("force", 0.6**3) == pytest.approx(0.6, abs=0.05)
    assert np.isnan(steady.first_time("force", 2.0))
    assert np.isnan(steady.at("force", [-0.1, 1.1])).all()
    gap = Readings(history | {"force": np.array([0.0, np.nan, 0.1, 0.4, 1.0])}, is_steady=True)
    assert gap.at("force", 0.875) == pytest.approx(0.7), "linear beside a value that is not there"


def test_reactions_and_torques_in_time_are_means():
    probes = [("f", "reaction"), ("t", "torque"), ("v", "velocity")]
    assert mean_columns(probes, is_steady=False) == ("f", "t")
    assert mean_columns(probes, is_steady=True) == ()


def sheared(**more) -> Case:
    """A cube whose shear stress relaxes after a fast shear; its nodes move along x alone."""
    everywhere = {"box": {"lower": (-1, -1, -1), "upper": (1, 1, 1)}}
    law = {"kind": "decoupled-neo-hookean", "young_modulus": 2.6 * MODULUS, "poisson_ratio": 0.3}
    branch = {"share": AT_START, "relaxation_time": LAG}
    table = {
        "schema": 1,
        "title": "Relaxation",
        "time": {"end": 0.15},
        "output": {"history": HISTORY},
        "body": [
            {
                "name": "gel",
                "kind": "meshless-solid",
                "mesh": {"box": {"lower": (0, 0, 0), "upper": (EDGE, EDGE, EDGE), "cells": (1, 1, 1)}},
                "damping": 2e3,
                "material": {"kind": "prony", "density": 10, "elastic": law, "branches": [branch]},
            }
        ],
        "support": [
            {"where": everywhere, "fix": ["y", "z"]},
            {"where": {"box": {"lower": (-1, -1, -1), "upper": (1, 1, 1e-9)}}},
        ],
        "motion": [
            {"name": "plate", "body": "gel", "part": {"normal": (0, 0, 1)}}
            | {"displacement": {"x": {"kind": "ramp", "distance": SHEAR * EDGE, "duration": RISE}}}
        ],
        "probe": [{"name": "force", "quantity": "reaction", "condition": "plate", "component": "x"}],
    }
    return Case.model_validate(table | more)


def shear_force(times):
    """By the integral of the relaxation over the ramp, for times after it [N]."""
    grown = LAG / RISE * (np.exp(RISE / LAG) - 1.0)
    return SHEAR * MODULUS * EDGE**2 * (1.0 + AT_START * grown * np.exp(-times / LAG))


def write_curve(path, times, values):
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([("time", "force"), ("s", "N"), *zip(times.tolist(), values.tolist(), strict=True)])
    return path


def test_check_fit_and_curve_follow_an_exact_relaxation(tmp_path):
    times = np.linspace(0.02, 0.15, 24)
    file = write_curve(tmp_path / "exact.csv", times, shear_force(times))
    check = {
        "name": "relaxation",
        "column": "force",
        "curve": {"path": str(file)},
        "relative_tolerance": 2e-3,
        "source": "exact",
    }
    run = pellucid.run(sheared(check=[check]), tmp_path / "run", report=False)
    at, force = run.curve("force")
    late = at > 2.0 * HISTORY
    assert np.abs(force[late] / shear_force(at[late]) - 1.0).max() < 1e-3  # means (h/τ)²/24, and swings of the inner node
    rows = run.history["time"] > 2.0 * HISTORY
    assert np.abs(run.history["force"][rows] / shear_force(run.history["time"][rows]) - 1.0).max() > 0.015
    assert run.metrics["relaxation"].passed, run.metrics["relaxation"]
    curve = read_curve(file, "force", run.case, 1.0)
    assert np.abs(curve.residuals(run)).max() < 1e-3 * shear_force(0.0)
    again = read_curve(run.out / "history.csv", "force", run.case, 1.0)
    assert np.abs(again.residuals(run)).max() < 1e-12, "the history of a run is read as that of the run that is fitted"
