"""Initial tension of membranes: equilibrium, energy, and the frequency of a taut square."""

import numpy as np
import pytest
from membranes import SURFACE_LAWS, THICKNESS, E, sheet
from small_cases import advance, case, simulation

from pellucid.bodies.membranes.prestretch import prestretch
from pellucid.grid.lattice import Grid
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import Flip
from pellucid.materials.law import energy
from pellucid.materials.linear_membrane import LinearMembrane
from pellucid.materials.membrane import plane_response, shape_of
from pellucid.materials.membrane_material import MEMBRANE_MATERIALS, SolidMembraneMaterial
from pellucid.materials.neo_hookean_membrane import NeoHookeanMembrane
from pellucid.parts.body import Placement

TENSION, DENSITY = 40.0, 1000.0
KINDS = {
    "points": {"kind": "membrane-points"},
    "quadrilaterals": {"kind": "membrane-elements"},
    "triangles": {"kind": "membrane-elements", "elements": "triangles"},
}


def taut(kind, law="linear-membrane", n=21, tension=TENSION):
    """A square of 1 m whose rim is held: by a motion, which every kind of membrane follows."""
    square = {"rectangle": {"corner": [0, 0, 0], "first_edge": (1, 0, 0), "second_edge": (0, 1, 0), "points": (n, n)}}
    table = sheet(law) | {"surface": square, "thickness": THICKNESS, "tension": tension, "name": "sheet"} | KINDS[kind]
    held = []
    for name, lower, upper in (
        ("left", (-0.01, -0.01, -1), (0.01, 1.01, 1)),
        ("right", (0.99, -0.01, -1), (1.01, 1.01, 1)),
        ("front", (0.011, -0.01, -1), (0.989, 0.01, 1)),
        ("back", (0.011, 0.99, -1), (0.989, 1.01, 1)),
    ):
        held.append({"name": name, "body": "sheet", "hold": ["x", "y", "z"], "part": {"box": {"lower": lower, "upper": upper}}})
    grid = {"counts": (20, 20, 8), "cell": 0.075, "lower": (-0.25, -0.25, -0.3), "functions": "quadratic-bspline"}
    return simulation(table, motion=held, end=10.0, **grid)


@pytest.mark.parametrize("law", ["linear-membrane", "neo-hookean-membrane"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_held_sheet_stays_at_rest_under_its_tension(kind, law):
    sim = taut(kind, law)
    stress = sim.bodies[0].field("stress")
    assert stress[:, :2] == pytest.approx(TENSION / THICKNESS, rel=1e-9)
    assert sim.bodies[0].mass == pytest.approx(DENSITY * THICKNESS)
    law = sim.bodies[0].law if kind == "points" else sim.bodies[0].surface.law
    stored = prestretch(lambda thickness: law, TENSION, THICKNESS).energy
    assert sim.budget.energies()["strain"] == pytest.approx(stored * THICKNESS, rel=1e-9)
    advance(sim, 50)
    assert np.abs(sim.bodies[0].arrays["velocity"]).max() < 1e-9
    assert sim.bodies[0].field("stress")[:, :2] == pytest.approx(TENSION / THICKNESS, rel=1e-9)


@pytest.mark.parametrize(("kind", "tolerance"), [("points", 0.03), ("quadrilaterals", 0.01), ("triangles", 0.01)])
def test_a_taut_square_swings_at_its_frequency(kind, tolerance):
    """f = √(T/m) √2/2a of the first mode; elements of 1/20 are right to (π/20)²/12 and less, points on cells of 1/20 less so:
    their rim is held by nodes half a cell wide."""
    sim = taut(kind)
    arrays = sim.bodies[0].arrays
    x, y, _ = arrays["position"].T
    arrays["velocity"][:, 2] = 1e-3 * np.sin(np.pi * x) * np.sin(np.pi * y)
    sim.bodies[0].renew_totals()
    period = 2.0 / (np.sqrt(2.0) * np.sqrt(TENSION / (DENSITY * THICKNESS)))
    middle = arrays["id"][np.argmin((x - 0.5) ** 2 + (y - 0.5) ** 2)]
    before, before_time = 0.0, 0.0
    while sim.time < 0.75 * period:
        sim.step()
        arrays = sim.bodies[0].arrays
        height = float(arrays["position"][arrays["id"] == middle, 2][0])
        if height <= 0.0 < before:
            crossing = before_time + (sim.time - before_time) * before / (before - height)
            break
        before, before_time = height, sim.time
    assert crossing == pytest.approx(0.5 * period, rel=tolerance)


def test_tension_by_linear_elasticity():
    """σ = E ln λ/(1 - ν)."""
    found = prestretch(lambda thickness: LinearMembrane(1e6, 0.3), 5.0, 1e-3)
    assert np.log(found.stretch) == pytest.approx(5e3 * 0.7 / 1e6)
    assert found.stress == pytest.approx((5e3, 5e3, 0.0))
    assert found.energy == pytest.approx(5e3**2 * 0.7 / 1e6, rel=0.01)  # σ²(1 - ν)/E for small strains


def test_energy_is_the_work_of_the_tension():
    law, small = NeoHookeanMembrane(4e6, 1e6), 1e-5
    low, high = (prestretch(lambda thickness: law, tension, 1e-3) for tension in (300.0 * (1 - small), 300.0 * (1 + small)))
    volume = [state.stretch**2 * state.ratio for state in (low, high)]
    gained = high.energy * volume[1] - low.energy * volume[0]
    mean = 0.5 * (low.stress[0] * low.ratio * low.stretch + high.stress[0] * high.ratio * high.stretch)
    assert gained == pytest.approx(2.0 * mean * (high.stretch - low.stretch), rel=1e-6)


def test_a_tension_that_no_stretch_bears_is_refused():
    with pytest.raises(ValueError, match="the material cannot carry the tension of 1e\\+09 N/m"):
        taut("triangles", tension=1e9)


SOLIDS = MEMBRANE_MATERIALS.kinds_of(SolidMembraneMaterial)
INFLATION = 0.2


def inflated(kind, body):
    """A square of 1 m under inflation, not complete, so that nothing is compiled."""
    surface = {"rectangle": {"corner": [-0.5, -0.5, 0], "first_edge": (1, 0, 0), "second_edge": (0, 1, 0), "points": (11, 11)}}
    moduli = SURFACE_LAWS.get(kind, {"young_modulus": E, "poisson_ratio": 0.3})
    table = sheet() | {"surface": surface, "inflation": INFLATION, "kind": body, "elements": "triangles"}
    if body == "membrane-points":
        del table["elements"]
    table["material"] = {"kind": kind, "density": DENSITY, **moduli}
    whole = case(table, counts=(16, 16, 16), cell=0.25, lower=(-2.0, -2.0, -2.0))
    model, field = whole.body[0], VelocityField("common", Grid(whole.grid))
    return model, model.build(Placement(whole.grid, field, Flip(), (0.0, 0.0, 0.0), 0))


def stretched_energy(law, stretch):
    """Of unit volume at rest under equal stretch [J/m³]: what the law states, or for the linear one ∫ 2σ (h/h₀) λ dλ with
    σ = E ε/(1 - ν) and h/h₀ = 1 - 2ν ε/(1 - ν) by ε = ln λ, dλ = λ dε."""
    if not isinstance(law, LinearMembrane):
        return energy(law, (stretch, 0.0, 0.0, stretch))
    strain, part = np.log(stretch) * np.linspace(0.0, 1.0, 20001), 1.0 - law.nu
    return np.trapezoid(2.0 * law.E / part * strain * (1.0 - 2.0 * law.nu / part * strain) * np.exp(2.0 * strain), strain)


@pytest.mark.parametrize("body", ["membrane-points", "membrane-elements"])
@pytest.mark.parametrize("kind", SOLIDS)
def test_inflation_stores_the_energy_of_the_law(kind, body):
    model, built = inflated(kind, body)
    law, stretch = built.law if body == "membrane-points" else built.surface.law, 1.0 + INFLATION
    *stress, ratio = plane_response(law, shape_of(law, (1.0, 1.0, 0.0), stretch, stretch))
    wanted = stretched_energy(law, stretch) / (stretch**2 * ratio) * model.thickness  # over the square as it is
    if body == "membrane-points":
        stored = float((built.arrays["mass"] * built.arrays["strain_energy"]).sum())
        started = built.arrays["plane_stress"]
    else:
        stored = float(built.element_arrays["strain_energy"].sum())
        started = built.element_arrays["plane_stress"] / ratio  # of triangles the second Piola-Kirchhoff stress
    assert stored == pytest.approx(wanted, rel=1e-8)
    assert started == pytest.approx(np.tile(stress, (len(started), 1)))
