import csv
from math import pi, sqrt
from pathlib import Path
from types import ModuleType

import pytest

from pellucid.references.solids import Layer, at_contact, force

FOLDER = Path(__file__).parents[2] / "validation" / "sphere-on-layer"


def script(name: str) -> ModuleType:
    module = ModuleType(name)
    module.__file__ = str(FOLDER / f"{name}.py")
    exec((FOLDER / f"{name}.py").read_text(encoding="utf-8"), module.__dict__)
    return module


@pytest.fixture(scope="module")
def influence() -> ModuleType:
    return script("influence")


@pytest.fixture(scope="module")
def blocks() -> ModuleType:
    return script("blocks")


def table(name: str) -> list[dict[str, str]]:
    with (FOLDER / f"{name}.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def hertz(young_modulus: float, poisson_ratio: float, radius: float, depth: float) -> float:
    """Force [N] on a rigid sphere of a radius [m] that is a depth [m] in a half-space.

    Source: K. L. Johnson, Contact Mechanics, 1985, eq. 4.23.
    """
    return 4.0 / 3.0 * young_modulus / (1.0 - poisson_ratio**2) * sqrt(radius * depth**3)


@pytest.mark.parametrize("bonded", [True, False])
def test_a_thick_layer_is_hertz_half_space(bonded: bool) -> None:
    layer = Layer(3000.0, 0.3, 1e3, bonded)
    depth, push = at_contact(layer, radius=1.0, contact=0.1)
    assert depth == pytest.approx(0.01, rel=1e-3)
    assert push == pytest.approx(hertz(3000.0, 0.3, 1.0, depth), rel=1e-3)


@pytest.mark.parametrize("ratio", [0.05, 0.2, 0.5])
def test_an_incompressible_bonded_layer_is_as_published(ratio: float) -> None:
    # P. D. Garcia & R. Garcia, Biophys. J. 114 (2018) 2923-2932: a series in √(Rδ)/h
    radius, thickness = 2.0, 0.5
    depth = (ratio * thickness) ** 2 / radius
    series = 1.0 + 1.133 * ratio + 1.497 * ratio**2 + 1.469 * ratio**3 + 0.755 * ratio**4
    push = force(Layer(1.0, 0.5, thickness, True), radius, depth)
    assert push / hertz(1.0, 0.5, radius, depth) == pytest.approx(series, rel=0.01)


@pytest.mark.parametrize(("bonded", "over_hertz"), [(True, 1.0445), (False, 1.0384)])
def test_finite_elements_agree(bonded: bool, over_hertz: float) -> None:
    # validation/sphere-on-layer/indentation.csv: finite strain and a finite width differ by 1.2 % from this theory
    push = force(Layer(1.0, 0.3, 4.0, bonded), radius=1.0, depth=0.02)
    assert push / hertz(1.0, 0.3, 1.0, 0.02) == pytest.approx(over_hertz, rel=0.015)


def test_a_contact_much_wider_than_the_layer_is_refused() -> None:
    with pytest.raises(ValueError, match="twice the thickness"):
        at_contact(Layer(1.0, 0.3, 0.01, True), radius=1.0, contact=0.1)


@pytest.mark.parametrize("bonded", [True, False])
@pytest.mark.parametrize(("poisson_ratio", "thickness"), [(0.0, 1.0), (0.45, 2.0)])
def test_pressures_on_rings_agree(influence: ModuleType, poisson_ratio: float, thickness: float, bonded: bool) -> None:
    layer = Layer(1.0 - poisson_ratio**2, poisson_ratio, thickness, bonded)
    found, contact = influence.press(influence.of_rings, 0.05, (thickness, poisson_ratio, bonded), influence.parabola)
    assert found == pytest.approx(force(layer, radius=1.0, depth=0.05), rel=5e-4)
    assert at_contact(layer, 1.0, contact)[0] == pytest.approx(0.05, rel=0.01)  # rings are half a per cent of the contact wide


def test_rings_on_a_half_space_bear_a_sphere_as_sneddon_has_it(influence: ModuleType) -> None:
    depth, exact = influence.of_sphere(0.3)
    assert exact == pytest.approx(0.99 * 4.0 / 3.0 * depth**1.5, rel=2e-3)  # a parabola bears 1 % more
    found, contact = influence.press(influence.of_rings, depth, (1e3, 0.3, True))
    assert found == pytest.approx(exact, rel=1e-3)
    assert contact == pytest.approx(0.3, rel=5e-3)


def test_strips_bear_a_cylinder_as_hertz_has_it(influence: ModuleType) -> None:
    # P = π E* a²/4R (K. L. Johnson, Contact Mechanics, 1985, eq. 4.43) for a half width far below the thickness
    found, half_width = influence.press(influence.of_strips, 0.001, (2.0, 0.3, False), rings=480)
    assert found == pytest.approx(0.25 * pi * half_width**2, rel=5e-3)


@pytest.mark.parametrize(("table", "function"), [("spheres", "of_rings"), ("cylinders", "of_strips")])
def test_tables_are_those_of_the_script(influence: ModuleType, table: str, function: str) -> None:
    with (FOLDER / f"{table}.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 54
    for row in rows[4::20]:
        layer = float(row["thickness"]), float(row["poisson_ratio"]), row["base"] == "bonded"
        found, contact = influence.press(getattr(influence, function), float(row["depth"]), layer)
        assert found == pytest.approx(float(row["force"]), rel=1e-5)
        assert contact == pytest.approx(float(row["contact"]), abs=1e-4)


@pytest.mark.parametrize("tool", ["sphere", "cylinder"])
def test_finite_elements_of_small_strains_agree_with_pressures(influence: ModuleType, blocks: ModuleType, tool: str) -> None:
    """Four elements in the contact; a side at twice the thickness and the penalty lower the force by 0.3 %."""
    function = influence.of_rings if tool == "sphere" else influence.of_strips
    layer, _ = influence.press(function, 0.05, (1.0, 0.3, True))
    ((found, _),) = blocks.indent(1.0, 2.0, 0.3, (0.05,), tool == "sphere", finite=False, per_contact=4)
    assert found * (1.0 - 0.3**2) == pytest.approx(layer, rel=0.01)


def test_finite_strain_agrees_with_felupe() -> None:
    """indentation.csv is good to 1 %."""
    bonded = [row for row in table("indentation") if row["bonded"] == "bonded"]
    others = {tuple(float(row[k]) for k in ("thickness", "width", "poisson", "depth")): row for row in bonded}
    found = [row for row in table("blocks") if (row["tool"], row["strains"]) == ("sphere", "finite")]
    compared = 0
    for row in found:
        key = tuple(float(row[k]) for k in ("thickness", "width", "poisson_ratio", "depth"))
        if key in others:
            over_hertz = float(row["force"]) / hertz(1.0, key[2], 1.0, key[3])
            assert over_hertz == pytest.approx(float(others[key]["finite_elements"]), rel=0.01)
            compared += 1
    assert compared == 4


def test_blocks_are_those_of_the_script(blocks: ModuleType) -> None:
    """With a third of the elements the force is within 0.5 %."""
    ((found, _),) = blocks.indent(1.0, 2.0, 0.3, (0.05,), False, per_contact=4)
    kept = [row for row in table("blocks") if tuple(row.values())[:6] == ("cylinder", "1.0", "2.0", "0.3", "finite", "0.05")]
    assert found == pytest.approx(float(kept[0]["force"]), rel=5e-3)
