"""Whether a case fits into the memory is counted as it will be laid out."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from pellucid.bodies.material_points.seeding import points_along_axes, seed
from pellucid.bodies.meshless_solid.functions import make_tables
from pellucid.case import Case, check_memory, loads, memory
from pellucid.cli import app
from pellucid.errors import CaseError
from pellucid.grid.lattice import Grid
from pellucid.grid.own_nodes_field import ReachedNodes
from pellucid.materials.kelvin_voigt import KelvinVoigtMaterial

BLOCK = """
schema = 1
title = "A block"
[grid]
lower = [0, 0, 0]
upper = [1, 1, 1]
cell = 0.1
[time]
end = 0.1
[[body]]
name = "block"
shape = { box = { lower = [0, 0, 0], upper = [0.5, 0.5, 0.5] } }
material = { kind = "neo-hookean", density = 1000, young_modulus = 1e5, poisson_ratio = 0.3 }
"""


def owner_of(array: np.ndarray) -> np.ndarray:
    """The array whose memory it shows."""
    while isinstance(array.base, np.ndarray):
        array = array.base
    return array


@pytest.fixture(params=["flat", "solid"])
def case(request: pytest.FixtureRequest, text: str) -> Case:
    return loads(text if request.param == "flat" else BLOCK)


def test_nodes_and_points_are_counted(case: Case) -> None:
    grid = Grid(case.grid)
    assert memory.n_nodes(case) == grid.n_nodes
    memories = {id(owner): owner.nbytes for owner in map(owner_of, grid.nodes)}
    reached = (owner_of(array).nbytes for array in vars(ReachedNodes(grid)).values() if isinstance(array, np.ndarray))
    room = memory.NODE_BYTES * grid.n_nodes + 1000  # what is added to align the arrays
    assert 0.9 * room < sum(memories.values()) + sum(set(reached)) <= room
    thin = case.grid.thin()
    points = [seed(b.shape.geometry(), case.grid, points_along_axes(b.points_per_cell, thin)).position for b in case.body]
    assert memory.n_points(case) == pytest.approx(sum(map(len, points)), rel=0.05)


def test_nodes_are_counted_once_for_each_velocity_field() -> None:
    sheet = {
        "rectangle": {"corner": [0.2, 0.2, 0.8], "first_edge": [0.6, 0, 0], "second_edge": [0, 0.6, 0], "points": [13, 13]}
    }
    material = {"kind": "linear-membrane", "density": 1000, "young_modulus": 1e5, "poisson_ratio": 0.3}
    table = {"kind": "membrane-elements", "surface": sheet, "thickness": 0.01, "material": material}
    data = loads(BLOCK).to_data()
    alone = Grid(loads(BLOCK).grid).n_nodes
    for field, sets in (("common", 1), ("net", 2)):
        both = Case.model_validate(data | {"body": [*data["body"], table | {"name": "net", "field": field}]})
        assert memory.n_nodes(both) == sets * alone


def test_what_fits_passes_and_what_does_not_names_need_and_remedy(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    check_memory(case)
    monkeypatch.setattr(memory, "physical_memory", lambda: 2**16)
    with pytest.raises(CaseError) as caught:
        check_memory(case)
    (problem,) = caught.value.problems
    assert problem.key == "grid.cell"
    assert "GiB of memory, but this machine has 6.1e-05 GiB" in problem.text
    assert float(problem.remedy.split("above ")[1].split()[0]) > case.grid.cell
    monkeypatch.setattr(memory, "physical_memory", lambda: None)
    check_memory(case)


@pytest.mark.parametrize("count", [4000**3, (4000, 4000, 4000)])
def test_points_that_no_cell_is_large_enough_for_are_blamed(monkeypatch: pytest.MonkeyPatch, count: object) -> None:
    case = loads(BLOCK).with_settings({"body.block.points_per_cell": count})
    monkeypatch.setattr(memory, "physical_memory", lambda: 2**30)
    with pytest.raises(CaseError) as caught:
        check_memory(case)
    (problem,) = caught.value.problems
    assert problem.key == "body.block.points_per_cell"
    assert 5**3 * memory.POINT_BYTES * float(problem.remedy.split("at most ")[1].split()[0]) == pytest.approx(
        2**30 - memory.PROGRAM_BYTES - memory.NODE_BYTES * memory.n_nodes(case), rel=0.05
    )


TISSUE = """
schema = 1
title = "A tissue"
[time]
end = 0.1
[[body]]
kind = "meshless-solid"
name = "tissue"
mesh = { box = { lower = [0, 0, 0], upper = [1, 1, 1], cells = [6, 6, 6] } }
material = { kind = "neo-hookean", density = 1000, young_modulus = 1e5, poisson_ratio = 0.3 }
"""


def test_tables_of_a_meshless_solid_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    case = loads(TISSUE)
    (body,) = case.body
    mesh = body.mesh.mesh()
    solid = make_tables(mesh, body.approximant.evaluator(mesh), body.law(), 4, False, True).solid
    kept = sum(array.nbytes for array in (*solid.gradients, *solid.corners, solid.turns, solid.deformation, solid.weights))
    kelvin_voigt = KelvinVoigtMaterial(density=1000.0, elastic=body.material, viscosity=1.0)
    changed = body.model_copy(update={"material": kelvin_voigt})
    history = 8 * (6 + 9 + 1) * 4 * len(mesh.cells)  # stress, deformation gradient and lost energy of a point
    assert changed.table_bytes() == body.table_bytes() + history
    assert kept < body.table_bytes() < 6.0 * kept  # more than twice as much is held while they are made
    monkeypatch.setattr(memory, "physical_memory", lambda: 2**20)
    with pytest.raises(CaseError) as caught:
        check_memory(case)
    (problem,) = caught.value.problems
    assert problem.key == "body"
    assert "requires about 0.31" in problem.text
    assert "shape functions at quadrature points" in problem.text
    assert "coarser mesh" in problem.remedy


@pytest.mark.parametrize("command", ["validate", "run"])
def test_a_grid_beyond_any_machine_is_an_error_of_its_line(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("big.toml").write_text(BLOCK.replace("cell = 0.1", "cell = 1e-5"))
    result = CliRunner().invoke(app, [command, "big.toml"])
    assert result.exit_code == 2
    for words in ("big.toml:7: grid.cell", "1e+15 grid nodes", "1e+15 points", "GiB of memory", "Set grid.cell above 0.0"):
        assert words in result.stderr
    assert not Path("runs").exists()


def test_a_setting_is_to_blame(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("block.toml").write_text(BLOCK)
    result = CliRunner().invoke(app, ["run", "block.toml", "--set", "grid.cell=1e-5"])
    assert result.exit_code == 2
    assert "--set grid.cell=1e-05: the case has" in result.stderr


def test_physical_memory_is_known_here() -> None:
    there = memory.physical_memory()
    assert there is None or np.log2(there) > 27
