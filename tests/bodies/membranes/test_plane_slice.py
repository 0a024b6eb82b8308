"""Plane problems: masses, energies and forces are those of a slice of the grid's thickness, whatever the cell."""

import numpy as np
import pytest
from small_cases import GAS, RATE_SOLID, SLIP, advance, box, case, simulation

from pellucid.bodies.membranes.plane_slice import slice_factor
from pellucid.grid.model import GridCase

KINDS = ("membrane-points", "membrane-elements")
SKIN = {"kind": "linear-membrane", "density": 10.0, "young_modulus": 1e3, "poisson_ratio": 0.3}
T = 0.3  # m


def band(depth=0.2, fine=12, **more):
    """A square skin of 1.2 m across which nothing varies, in a mesh of this depth [m]."""
    points = (fine + 1, fine + 1, 2)
    rim = {"lower": (0.9, 0.9, 0.0), "upper": (2.1, 2.1, depth), "points": points, "open": ["z-lower", "z-upper"]}
    return {"kind": "membrane-elements", "name": "skin", "surface": {"box": rim}, "thickness": 0.05, "material": SKIN} | more


def gas(**more):
    return box((0.92, 0.92, 0.0), (2.08, 2.08, 0.0), GAS | {"pressure": 5.0}, (3, 3, 1), name="gas", **more)


def plane(*bodies, cell=0.2, thickness=T, **more):
    n = round(3.0 / cell)
    settings = {"end": 10.0, "functions": "quadratic-bspline", "energy": {"warn": 1.0, "stop": 10.0}} | more
    return simulation(*bodies, counts=(n, n, 0), cell=cell, thickness=thickness, **settings)


def masses(sim):
    return [body.arrays["mass"].sum() for body in sim.bodies]


@pytest.mark.parametrize("kind", KINDS)
def test_mass_does_not_depend_on_the_cell_nor_on_the_depth_of_the_mesh(kind):
    disc = box((0, 0, 0), (1, 1, 1), name="disc") | {"shape": {"sphere": {"centre": (0.45, 0.45, 0), "radius": 0.4}}}
    wanted = np.array([1.16**2 * T, 10.0 * 0.05 * 4.8 * T, 1000.0 * np.pi * 0.16 * T])
    for cell, depth in ((0.2, 0.2), (0.1, 0.1), (0.2, 0.05)):
        sim = plane(gas(), band(depth, 24, kind=kind), disc, cell=cell)
        assert masses(sim) == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_a_line_is_a_bar_of_thickness_by_thickness(kind):
    plate = {"corner": (0.55, 0, 0), "first_edge": (0, 0.02, 0), "second_edge": (0, 0, 0.05), "points": (2, 2)}
    piston = {"kind": kind, "name": "piston", "surface": {"rectangle": plate}, "thickness": 0.01, "material": SKIN}
    bodies = [box((0, 0, 0), (0.5, 0, 0), GAS)] + [piston | {"field": "other"}] * (kind == "membrane-elements")
    for cell in (0.1, 0.05):
        sim = simulation(*bodies, counts=(round(1.0 / cell), 0, 0), cell=cell, thickness=T)
        assert masses(sim) == pytest.approx([0.5 * T * T, 10.0 * 0.01 * T * T][: len(bodies)], rel=1e-12)


def test_a_sheet_in_the_plane_has_its_own_thickness():
    """Plane stress: across the plane lies the membrane's thickness, and not the grid's."""
    flat = {"corner": (1, 1, 0), "first_edge": (1, 0, 0), "second_edge": (0, 1, 0), "points": (12, 12)}
    for kind in KINDS:
        sheet = {"kind": kind, "name": "sheet", "surface": {"rectangle": flat}, "thickness": 0.05, "material": SKIN}
        assert masses(plane(sheet)) == pytest.approx([10.0 * 0.05], rel=1e-12)


def test_a_grid_without_thin_axes_leaves_membranes_as_they_are():
    vertices = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 2.0)])
    assert slice_factor(vertices, GridCase(lower=(0, 0, 0), upper=(1, 1, 2), cell=0.5)) == 1.0
    assert slice_factor(vertices, GridCase(lower=(0, 0, 0), upper=(1, 1, 0), cell=0.5, thickness=0.5)) == 0.25


def loaded(kind, thickness):
    """Gas in a skin under pressure and gravity, beside a face that absorbs and above a floor that it presses on."""
    floor = [{"name": "floor", "where": "y-lower", "fix": "normal"}]
    ground = box((0.05, 0, 0), (2.95, 0.6, 0), RATE_SOLID, (2, 2, 1), name="ground", velocity=(0.0, -0.1, 0.0))
    return plane(
        band(kind=kind, velocity=(0.3, -0.2, 0.0)),
        gas(),
        ground,
        thickness=thickness,
        gravity=(0.0, -2.0, 0.0),
        support=floor,
        pressure=[{"body": "skin", "value": 3.0, "rise": 0.02}],
        absorbing=[{"body": "ground", "where": ["x-upper"]}],
        motion=[{"name": "drag", "body": "skin", "part": PART, "displacement": {"x": {"kind": "steady", "velocity": 0.1}}}],
    )


PART = {"box": {"lower": (2.0, 0.8, -1.0), "upper": (2.2, 1.0, 8.0)}}


def meeting(kind, thickness):
    """A block flies against a skin in a field of its own: contact, and hourglass control of elements."""
    block = box((1.3, 0.45, 0), (1.7, 0.85, 0), RATE_SOLID, name="block", velocity=(0.1, 1.0, 0.0), field="other")
    return plane(band(kind=kind), block, thickness=thickness, contact=[{"name": "blow", "between": ["skin", "block"]}])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("sim", [loaded, meeting])
def test_everything_that_adds_up_grows_with_the_thickness_and_nothing_else(sim, kind):
    """By a power of two, so that the bits of what does not grow are the same."""
    thin, thick = (advance(sim(kind, t), 40) for t in (0.25, 2.0))
    assert thick.time == thin.time
    for one, other in zip(thin.bodies, thick.bodies, strict=True):
        for name in {*one.field_names, "stress", "density"}:
            grown = 8.0 if name in ("mass",) else 1.0
            assert np.array_equal(other.field(name), grown * one.field(name)), name
    small, large = thin.budget.energies(), thick.budget.energies()
    assert {name: 8.0 * value for name, value in small.items()} == large
    assert np.array_equal(thick.momentum(), 8.0 * thin.momentum())
    reactions = thin.budget.reactions()
    assert reactions
    for name, reaction in thick.budget.reactions().items():
        assert np.any(reaction), name
        assert np.array_equal(reaction, 8.0 * reactions[name])
    assert thick.budget.conservation()["energy"] == thin.budget.conservation()["energy"]


@pytest.mark.parametrize("kind", KINDS)
def test_pressure_pushes_the_slice(kind):
    """On an open strip 1 m long, p L T t, whatever cell and depth; points and elements alike."""
    for cell, depth in ((0.2, 0.2), (0.1, 0.05)):
        strip = {"corner": (1, 1.5, 0), "first_edge": (0, 0, depth), "second_edge": (1, 0, 0), "points": (2, 25)}
        body = {"kind": kind, "name": "skin", "surface": {"rectangle": strip}, "thickness": 0.05, "material": SKIN}
        sim = advance(plane(body, cell=cell, pressure=[{"body": "skin", "value": 3.0}]), 10)
        assert sim.momentum() == pytest.approx([0.0, 3.0 * T * sim.time, 0.0], rel=1e-12, abs=1e-13)
        assert sim.budget.conservation()["momentum"] < 1e-12


def test_the_floor_bears_the_weight_of_the_slice():
    for cell in (0.2, 0.1):
        block = box((0, 0, 0), (3, 0.6, 0), RATE_SOLID, name="block")
        floor = {"name": "floor", "where": "y-lower", "fix": "normal"}
        sim = plane(block, cell=cell, gravity=(0, -10, 0), support=[*SLIP[:2], floor])
        while sim.time < 1.0:
            sim.step()
        weight = 1000.0 * 3 * 0.6 * T * 10.0
        assert sim.budget.reactions()["floor"][1] == pytest.approx(
            weight * sim.time + sim.momentum()[1], rel=1e-9
        )  # its impulse


@pytest.mark.parametrize(("kind", "balance"), [("membrane-points", 0.02), ("membrane-elements", 0.001)])
def test_gas_in_a_skin_has_the_same_energies_on_any_grid(kind, balance):
    """A finer grid changes them by its error, and not by its cell; the balance closes on both to what the kind is good for."""
    found = []
    for cell, depth in ((0.2, 0.2), (0.1, 0.1)):
        sim = plane(gas(), band(depth, 24, kind=kind), cell=cell, courant=0.2)
        start = sim.budget.energies()["internal"]
        assert start == pytest.approx(5.0 / 0.4 * 1.16**2 * T, rel=1e-12)
        while sim.time < 0.5:
            sim.step()
        assert sim.budget.conservation()["energy"] < balance
        found.append([sim.budget.energies()[name] / start for name in ("internal", "kinetic", "strain")])
    assert found[0] == pytest.approx(found[1], abs=0.03)  # of all energy; cells are a tenth of the skin wide


BALL = {"icosphere": {"centre": (1.5, 1.5, 0.5), "radius": 0.5, "refinements": 4}}
DISC = {"disc": {"centre": (1.5, 1.5, 0.5), "normal": (1, 0, 0), "radius": 0.5, "rings": 12}}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("surface", [BALL, DISC], ids=["ball", "disc across the plane"])
def test_a_surface_that_is_no_band_is_refused(kind, surface):
    body = {"kind": kind, "name": "skin", "surface": surface, "thickness": 0.05, "material": SKIN}
    with pytest.raises(ValueError, match="is neither flat across z nor a band along it"):
        plane(body, cell=1.0)
    case(body, counts=(30, 30, 20), cell=0.1, lower=(0, 0, -1))


@pytest.mark.parametrize("kind", KINDS)
def test_a_band_deeper_than_the_cell_is_refused(kind):
    words = r"extends from 0 to 0\.2 m along z, beyond the grid's one cell there: 0 to 0\.1 m"
    with pytest.raises(ValueError, match=words):
        plane(band(0.2, 24, kind=kind), cell=0.1)
