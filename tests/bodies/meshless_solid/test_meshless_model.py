"""Meshless solids as users describe them: what is refused, and a pull as in the documents."""

import tomllib

import numpy as np
import pytest
from solids import EDGE, PULL, TISSUE, block, block_of, pulled_block
from typer.testing import CliRunner

from pellucid.case import Case
from pellucid.cli import app
from pellucid.errors import CaseError
from pellucid.grid.lattice import Grid
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import Flip
from pellucid.parts.body import Placement
from pellucid.simulation.simulation import Simulation


def clamped(**body):
    """A block between a clamp and a clamp that moves up by PULL in 0.3 s."""
    return Case.model_validate(pulled_block(0.3, 0.4, **body))


BOX = block_of()["mesh"]["box"]


@pytest.mark.parametrize(
    ("body", "words"),
    [
        (
            {"material": {"kind": "linear-elastic", **{k: TISSUE[k] for k in TISSUE if k != "kind"}}},
            "no energy as a function of the deformation",
        ),
        ({"mesh": {"box": BOX | {"cells": (3, 0, 3)}}}, r"box\.cells\.1\n.*greater than or equal to 1"),
        ({"mesh": {"box": BOX | {"upper": (0.1, 0.1, -0.1)}}}, "`upper` must exceed `lower` along z"),
        ({"points_per_cell": 5}, "points_per_cell"),
        ({"approximant": {"kind": "maximum-entropy"}}, "cell-based-maximum-entropy"),
    ],
)
def test_what_cannot_be_is_refused(body, words):
    with pytest.raises((CaseError, ValueError), match=words):
        block(body=body)


BLOCK = """
title = "a test"
time = { end = 0.4 }
[[body]]
name = "block"
kind = "meshless-solid"
mesh = { box = { lower = [0, 0, 0], upper = [0.1, 0.1, 0.1], cells = [3, 3, 1] } }
material = { kind = "neo-hookean", density = 1000, young_modulus = "3 kPa", poisson_ratio = 0.49 }
approximant = { kind = "modified-moving-least-squares", dilatation = 1.6 }
[[support]]
name = "bottom"
where = { box = { lower = [-1, -1, -0.001], upper = [1, 1, 0.001] } }
"""


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("", "", []),
        (
            "-0.001], upper = [1, 1, 0.001]",
            "0.5], upper = [1, 1, 0.6]",
            [":12: support.bottom.where", "constrains nothing", "make it larger or move it"],
        ),
        (
            "dilatation = 1.6",
            "dilatation = 1.01",
            [":9: body.block.approximant.dilatation = 1.01", "too few neighbours", "increase it"],
        ),
        ("cells = [3, 3, 1]", "cells = [0, 3, 3]", [":7: body.block.mesh.box.cells.0 = 0", "at least 1 (number of cubes"]),
        ('"neo-hookean"', '"hgo"', [":8: body.block.material.kind", "did you mean `holzapfel-gasser-ogden`?"]),
        ("[3, 3, 1] }", "[3, 3, 1], grading = [0, 1, 1] }", ["box.grading.0 = 0", "at least 0.001 (ratio of the last"]),
    ],
)
def test_validate_finds_what_a_run_would(tmp_path, old, new, words):
    file = tmp_path / "block.toml"
    file.write_text(BLOCK.replace(old, new))
    result = CliRunner().invoke(app, ["validate", str(file)])
    assert result.exit_code == (2 if words else 0)
    for word in words:
        assert word in result.output


def test_validate_finds_no_functions_only_where_that_is_quick(monkeypatch):
    case = Case.model_validate(tomllib.loads(BLOCK.replace("1.6", "1.01")))
    with pytest.raises(CaseError, match="too few neighbours"):
        case.body[0].check_set_up()
    monkeypatch.setattr("pellucid.bodies.meshless_solid.model.MOST_TRIED", 10)
    case.body[0].check_set_up()


def test_in_a_plane_grid_it_is_refused():
    with pytest.raises((CaseError, ValueError), match="is three-dimensional, but this grid is one cell thick"):
        block(grid={"lower": (-1, -1, 0), "upper": (1, 1, 0), "cell": 0.1, "thickness": 0.1})


@pytest.mark.parametrize("field", [None, "tissue"])
def test_beside_others_it_needs_a_field_of_its_own(field):
    """On nodes that move points it would take no part in contact."""
    tables = [block_of(), block_of() | {"name": "other"} | ({} if field is None else {"field": field})]
    grid = {"lower": (-1, -1, -1), "upper": (2, 2, 2), "cell": 0.25}
    case = {"schema": 1, "title": "Two blocks", "grid": grid, "time": {"end": 1.0}, "body": tables}
    if field:
        assert len({body.field for body in Case.model_validate(case).body}) == 2
        return
    with pytest.raises(
        (CaseError, ValueError), match='other bodies share the velocity field "common", but a meshless solid needs its own'
    ):
        Case.model_validate(case)


def test_it_is_not_built_on_nodes_that_move_points():
    case = block(grid={"lower": (-1, -1, -1), "upper": (2, 2, 2), "cell": 0.25})
    field = VelocityField("common", Grid(case.grid))
    with pytest.raises(ValueError, match="the velocity field common moves its bodies"):
        case.body[0].build(Placement(case.grid, field, Flip(), (0.0, 0.0, 0.0), n_loads=0))


@pytest.fixture(scope="module")
def pulled():
    simulation = Simulation(clamped(), threads=1)
    for _ in range(400):
        if simulation.time >= 0.4 * (1.0 - 1e-12):
            break
        simulation.step()
    return simulation


def test_prescribed_nodes_are_where_they_must_be(pulled):
    body = pulled.bodies[0]
    start, now = body.mesh.nodes, body.arrays["position"]
    top, bottom = start[:, 2] > 0.0999, start[:, 2] < 1e-4
    assert now[top] == pytest.approx(start[top] + (0.0, 0.0, PULL), abs=1e-12)
    assert now[bottom] == pytest.approx(start[bottom], abs=1e-15)


def test_the_work_of_the_motion_is_stored(pulled):
    """Slowly pulled, all work goes into strain energy but for the swing that is left."""
    energies = pulled.budget.energies()
    assert energies["strain"] == pytest.approx(energies["motion_work"], rel=0.05)
    assert abs(pulled.budget.energy_error()) < 0.02
    assert pulled.budget.conservation()["momentum"] < 1e-12


def test_it_is_stiffer_than_a_free_bar_and_softer_than_a_confined_one(pulled):
    E, nu, strain, volume = 3e3, 0.49, PULL / EDGE, EDGE**3
    free, confined = 0.5 * E * strain**2 * volume, 0.5 * E * (1 - nu) / (1 + nu) / (1 - 2 * nu) * strain**2 * volume
    assert free < pulled.budget.energies()["strain"] < 0.5 * confined


def test_averaging_of_the_volume_ratio_takes_the_locking_away():
    energies = {}
    for averaged in (False, True):
        simulation = Simulation(clamped(volume_averaging=averaged), threads=1)
        while simulation.time < 0.3:
            simulation.step()
        energies[averaged] = simulation.budget.energies()["strain"]
    assert energies[True] < 0.97 * energies[False]


def test_damping_slows_a_free_block_at_its_rate():
    """Of second order in the step, here 1e-3 of the time constant; what the drag takes is heat."""
    simulation = Simulation(block(body={"velocity": (0.0, 0.0, 0.5), "damping": 0.25}), threads=1)
    start = simulation.budget.energies()["kinetic"]
    for _ in range(100):
        simulation.step()
    energies = simulation.budget.energies()
    assert simulation.bodies[0].totals.momentum[2] == pytest.approx(0.5 * np.exp(-0.25 * simulation.time), rel=1e-6)
    assert energies["damping_heat"] == pytest.approx(start - energies["kinetic"], rel=1e-12)
    assert simulation.budget.conservation()["momentum"] < 1e-12


def test_a_restart_goes_on_bit_for_bit():
    whole = Simulation(clamped(), threads=1)
    for _ in range(10):
        whole.step()
    kept = {name: np.copy(array) for name, array in whole.state_arrays().items()}, whole.state_numbers()
    for _ in range(5):
        whole.step()
    again = Simulation(clamped(), threads=1)
    again.restore(*kept)
    for _ in range(5):
        again.step()
    assert again.bodies[0].arrays["position"].tobytes() == whole.bodies[0].arrays["position"].tobytes()
    assert again.budget.energies() == whole.budget.energies()
