"""Rigid balls and cylinders on bonded layers by contact between surfaces, compared with finite elements of the same law."""

import csv
from pathlib import Path
from types import ModuleType

import pytest

from pellucid.contact.surface_pairs import SurfacePairs

FOLDER = Path(__file__).parents[2] / "validation" / "sphere-on-layer"

# The finite elements are good to 0.3 %. Meshless functions are linear where they are coarse, and the rim of the contact lies
# within an element: for elements of the width h the error of the force is in the order of (h/a)², with the half width a of the
# contact. A quarter of that is allowed: 4.5 % at 2.4 elements in it, 3.0 % at three, 1.4 % at five.
OF_SQUARE, OF_REFERENCE = 0.25, 3e-3
OF_POINTS = 0.03  # with three or more cells of material points in the contact, whose springs yield like a part of a cell


@pytest.fixture(scope="module")
def script() -> ModuleType:
    module = ModuleType("by_surfaces")
    module.__file__ = str(FOLDER / "by_surfaces.py")
    exec((FOLDER / "by_surfaces.py").read_text(encoding="utf-8"), module.__dict__)
    return module


def allowed(script: ModuleType, tool: str, finest: float) -> float:
    return OF_SQUARE * (finest / script.exact(tool, column="contact")) ** 2 + OF_REFERENCE


def test_a_cylinder_on_a_layer_in_a_steady_state(script: ModuleType) -> None:
    """Finer elements are in the slow tests and in by_surfaces.csv."""
    ratio, simulation = script.press("cylinder", "steady", 0.125, loading=400)
    assert ratio == pytest.approx(1.0, abs=allowed(script, "cylinder", 0.125))
    assert abs(simulation.budget.conservation()["energy"]) < 0.01
    assert "energy" not in simulation.state_numbers()["warned"], (
        "corrections of overlaps change forces at once, and are not judged"
    )


def test_a_cylinder_on_a_layer_of_material_points(script: ModuleType) -> None:
    """Springs as soft as a layer of cells gave 0.915. Nodes give moved points slightly other velocities than those with which
    the surface moved: 1e-4 of the work, in the order of the displacement in a step over the cell."""
    ratio, simulation = script.press("cylinder", "points", 0.1)
    assert ratio == pytest.approx(1.0, abs=OF_POINTS)
    work = simulation.budget.energies()["motion_work"]
    assert abs(simulation.budget.energies()["transfer_heat"]) < 5e-4 * work
    assert abs(simulation.parts.only(SurfacePairs).energy.unexplained) < 1e-3 * work


@pytest.mark.slow
@pytest.mark.parametrize(
    ("tool", "kind", "finest"),
    [
        *[("cylinder", "steady", 0.0625), ("cylinder", "meshless", 0.0625), ("sphere", "steady", 0.1)],
        pytest.param("sphere", "steady", 0.0625, marks=pytest.mark.full),
    ],
)
def test_layers_on_finer_elements(script: ModuleType, tool: str, kind: str, finest: float) -> None:
    ratio, _ = script.press(tool, kind, finest)
    assert ratio == pytest.approx(1.0, abs=allowed(script, tool, finest))


@pytest.mark.slow
@pytest.mark.parametrize(("tool", "finest"), [("cylinder", 0.0625), ("sphere", 0.125)])
def test_layers_of_material_points_on_finer_cells(script: ModuleType, tool: str, finest: float) -> None:
    ratio, _ = script.press(tool, "points", finest)
    assert ratio == pytest.approx(1.0, abs=OF_POINTS)


def test_the_table_converges_to_finite_elements(script: ModuleType) -> None:
    with (FOLDER / "by_surfaces.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    errors = {(row["tool"], row["solid"], float(row["finest"])): abs(float(row["over_finite_elements"]) - 1.0) for row in rows}
    for (tool, kind), sizes in script.RUNS.items():
        found = [errors[tool, kind, finest] for finest in sizes]
        assert found[-1] < found[0]
        for error, finest in zip(found, sizes, strict=True):
            cells = script.exact(tool, column="contact") / finest
            assert error < (
                max(OF_POINTS, OF_POINTS * (3.0 / cells) ** 2) if kind == "points" else allowed(script, tool, finest)
            )
