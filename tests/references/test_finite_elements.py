"""The tables of finite elements, and how a run is measured against them."""

import numpy as np
import pytest

from pellucid.case import load
from pellucid.references.finite_elements import largest_deviation, read, same_problem


@pytest.mark.parametrize(("table", "rows", "end"), [("net_impact", 201, 0.2), ("membrane_expansion", 121, 0.03)])
def test_tables_cover_the_whole_case(table, rows, end):
    columns = read(table)
    assert {len(column) for column in columns.values()} == {rows}
    assert columns["time"][0] == 0.0
    assert columns["time"][-1] == pytest.approx(end)
    assert np.all(np.diff(columns["time"]) > 0)


def test_a_net_that_slides_is_softer():
    net = read("net_impact")
    assert net["sliding_cuboid_z"].min() < net["tied_cuboid_z"].min() < -0.07
    for name in ("tied", "sliding"):
        # the net's middle stays at the cuboid, which hardly changes its height
        assert np.allclose(net[f"{name}_cuboid_z"], net[f"{name}_net_z"], atol=5e-4)


def test_before_the_net_pulls_the_cuboid_flies_with_the_common_momentum():
    net = read("net_impact")
    early = net["time"] <= 0.01
    common = 0.1 * 4000 / (0.1 * 4000 + 0.0125 * 2000)  # mass of the cuboid over that with the net under it
    speed = -net["tied_cuboid_z"][early][1:] / net["time"][early][1:]
    assert np.all(speed < 1.03 * common)
    assert np.all(speed > 0.95 * common)


def test_the_inertia_of_the_gas_hardly_matters():
    lid = read("membrane_expansion")
    for name in ("cube_z", "gas_pressure"):
        assert largest_deviation(lid["time"], lid[f"uniform_{name}"], lid["time"], lid[f"flowing_{name}"]) < 0.005


def test_the_cube_starts_as_the_pressure_drives_it():
    lid = read("membrane_expansion")
    time, rise = (lid[name][lid["time"] <= 0.0015][-1] for name in ("time", "uniform_cube_z"))
    acceleration = 2.0 * rise / time**2
    # 800 Pa on cube and lid, 50 kg/m²; the elements lump the cube with half an element (2.5 mm) of the lid about it
    lumped = 0.045**2
    assert 800.0 / 50.0 < acceleration < 800.0 * lumped / (0.04**3 * 1000.0 + lumped * 10.0)


def test_deviation_counts_in_changes_of_the_reference():
    times = np.linspace(0.0, 1.0, 11)
    reference = 5.0 - 2.0 * times
    assert largest_deviation(times, reference + 0.1, times, reference) == pytest.approx(0.05)
    half = times <= 0.5
    assert largest_deviation(times[half], (reference + times)[half], times, reference) == pytest.approx(0.25)


@pytest.mark.parametrize(
    ("settings", "same"),
    [
        ({"grid.cell": 0.05, "time.end": 0.1, "body.cuboid.points_per_cell": [2, 2, 2]}, True),
        ({"body.net.thickness": 0.01}, False),
        ({"body.net.material.young_modulus": 1e7}, False),
        ({"body.cuboid.velocity": [0, 0, -2]}, False),
        ({"body.cuboid.shape.box.lower": [0.4, 0, 0.00625]}, False),
        ({"gravity": [0, 0, -9.81]}, False),
    ],
)
def test_the_finite_elements_are_for_one_problem(settings, same):
    case = load("gan2011/net-impact")
    assert same_problem(case.with_settings(settings), case) is same
