"""Membranes by surface laws, of points and elements: directions, viscosity and its heat, steps that are stable."""

import numpy as np
import pytest
from elements import body_of as element_body
from elements import bring, bring_to, fastest_frequency, global_stress, places, single_element
from membranes import RIM, assert_stable_when_shaken, drive
from membranes import body_of as point_body
from pydantic import ValidationError
from small_cases import case, simulation

from pellucid.errors import CaseError
from pellucid.materials.holzapfel_gasser_ogden_membrane import HolzapfelGasserOgdenMembraneMaterial
from pellucid.materials.skalak_membrane import SkalakMembraneMaterial
from pellucid.materials.surface_law import surface_energy, surface_tension

THICKNESS, RHO = 1e-3, 1000.0
AXIS = np.array((1.0, 2.0, 0.0)) / np.sqrt(5.0)
FIBRES = {
    "kind": "holzapfel-gasser-ogden-membrane",
    "density": RHO,
    "shear_modulus": 1.0,
    "k1": 2.0,
    "k2": 0.8,
    "dispersion": 0.1,
    "fibre_direction": (*(3.0 * AXIS[:2]), 0.5),
    "fibre_angle": 20.0,
}
SKALAK = {"kind": "skalak-membrane", "density": RHO, "shear_modulus": 1.0, "area_coefficient": 1.0}
VISCOUS = SKALAK | {"viscosity": 0.3, "dilatational_viscosity": 0.2}
KINDS = {
    "points": {"kind": "membrane-points"},
    "quadrilaterals": {"kind": "membrane-elements"},
    "triangles": {"kind": "membrane-elements", "elements": "triangles"},
}
every_kind = pytest.mark.parametrize("kind", KINDS)
SETTINGS = {"counts": (14, 10, 8), "cell": 0.25, "lower": (-1.0, -1.25, -1.0), "functions": "quadratic-bspline", "end": 100.0}


def square(kind, material, n=9, **more):
    """A square of 1 m about the origin, in z = 0."""
    surface = {"rectangle": {"corner": [-0.5, -0.5, 0], "first_edge": (1, 0, 0), "second_edge": (0, 1, 0), "points": (n, n)}}
    return {"name": "sheet", "surface": surface, "thickness": THICKNESS, "material": material} | KINDS[kind] | more


def stretch(kind, table, L, time=1.0, steps=100):
    """Membrane of a kind after the velocity gradient L [1/s] has acted for a time, and its stress in the plane, (2, 2)."""
    if kind == "points":
        grid, body = point_body(table)
        drive(grid, body, L, time / steps, steps)
    else:
        body = element_body(table)
        for _ in range(steps):
            x = places(body)
            # nodes whose velocity is that of their middle of the step
            bring(
                body,
                x @ np.linalg.solve(np.eye(3) - 0.5 * time / steps * L, np.eye(3) + 0.5 * time / steps * L).T,
                time / steps,
            )
    return body, global_stress(body)[body.n_points // 2][:2, :2]


def deformation(L, time=1.0):
    from scipy.linalg import expm

    return expm(time * np.array(L))


@every_kind
@pytest.mark.parametrize("turned", [False, True], ids=["stretched", "and turned"])
def test_fibres_lie_along_their_direction(kind, turned):
    """Stress of a uniform deformation, beside the law in the axes of the fibres."""
    L = np.array([[0.2, 0.15, 0.0], [0.05, -0.1, 0.0], [0.0, 0.0, 0.0]]) + turned * np.array(
        [[0, -0.9, 0], [0.9, 0, 0], [0, 0, 0]]
    )
    _, stress = stretch(kind, square(kind, FIBRES), L, steps=1000 if kind == "points" else 100)  # points go to first order
    F = deformation(L)[:2, :2]
    along = np.array([[AXIS[0], -AXIS[1]], [AXIS[1], AXIS[0]]])  # columns: the axes at rest
    law = HolzapfelGasserOgdenMembraneMaterial(**FIBRES).elastic_law()
    t11, t22, t12 = surface_tension(law, tuple((F @ along).ravel()))
    expected = np.array([[t11, t12], [t12, t22]]) / THICKNESS
    assert stress == pytest.approx(expected, rel=3e-3, abs=3e-3 * np.abs(expected).max())


@every_kind
def test_viscosity_resists_and_is_heat(kind):
    """Stress beside that of the law by 2μ D + λ tr D over the thickness; the heat is its work, and the rest what is stored."""
    L, time, steps = np.diag((0.3, -0.1, 0.0)), 0.5, 400
    body, stress = stretch(kind, square(kind, VISCOUS), L, time, steps)
    F, D = deformation(L, time)[:2, :2], L[:2, :2]
    law = SkalakMembraneMaterial(**SKALAK).elastic_law()
    t11, t22, t12 = surface_tension(law, tuple(F.ravel()))
    J = np.linalg.det(F)
    viscous = 2.0 * 0.3 * D + 0.2 * np.trace(D) * np.eye(2)
    expected = np.array([[t11, t12], [t12, t22]]) + J * viscous
    assert stress == pytest.approx(expected / THICKNESS, rel=2e-3, abs=2e-3 * np.abs(expected / THICKNESS).max())
    times = np.linspace(0.0, time, 2001)
    heat = np.trapezoid(np.exp(times * np.trace(D)) * np.sum(viscous * D), times)
    assert body.totals.parts["dissipated"] == pytest.approx(heat, rel=2e-3)
    assert body.totals.stored - body.totals.parts.get("hourglass", 0.0) - heat == pytest.approx(
        surface_energy(law, tuple(F.ravel())), rel=0.02
    )


@every_kind
@pytest.mark.parametrize("viscosity", [0.0, 0.1, 1.0])
def test_a_stretched_skalak_sheet_is_stable(kind, viscosity):
    """The tangent at (1.4, 1.4) is some six times that at rest; steps of 0.9 of the bound, beside waves and viscosity alike."""
    T = 1.4**2 - 1.0 + 1.4**2 * (1.4**4 - 1.0)
    material = SKALAK if viscosity == 0.0 else SKALAK | {"viscosity": viscosity}
    sim = simulation(square(kind, material, tension=T), motion=RIM, courant=0.9, **SETTINGS)
    assert_stable_when_shaken(sim, 600)


@pytest.mark.parametrize("kind", ["quadrilaterals", "triangles"])
@pytest.mark.parametrize("material", [SKALAK, FIBRES], ids=["skalak", "fibres"])
@pytest.mark.parametrize("stretches", [(1.0, 1.0), (1.5, 1.1), (1.4, 1.4), (0.9, 0.85)])
def test_no_element_swings_faster_than_its_bound(kind, material, stretches):
    """Against the largest eigenfrequency by differences of the forces on its corners."""
    body = single_element(square(kind, material), kind)
    bring_to(body, stretches)
    # slack fibres count as taut, and those of a direction as in all
    assert 0.999 <= 2.0 * body.totals.rate / fastest_frequency(body) < (2.0 if material is SKALAK else 6.0)


@pytest.mark.parametrize("kind", ["quadrilaterals", "triangles"])
def test_the_energy_of_a_viscous_sheet_is_balanced(kind):
    sim = simulation(square(kind, VISCOUS), motion=RIM, courant=0.4, **SETTINGS)
    arrays = sim.bodies[0].arrays
    arrays["velocity"][:, 0] = 0.2 * np.cos(np.pi * arrays["position"][:, 0]) * np.cos(np.pi * arrays["position"][:, 1])
    sim.bodies[0].renew_totals()
    sim.begin_balance()
    start = sim.budget.energies()["kinetic"]
    for _ in range(600):
        sim.step()
    found = sim.budget.energies()
    assert found["dissipated"] == pytest.approx(start, rel=0.03)  # to first order in the step
    assert abs(found["time_integration_error"]) < 5e-3 * start


def test_a_direction_across_the_surface_is_told():
    across = FIBRES | {"fibre_direction": (0.0, 0.0, 1.0)}
    with pytest.raises((CaseError, ValidationError, ValueError), match="fibre_direction is normal to the surface at"):
        simulation(square("triangles", across), **SETTINGS)
    with pytest.raises((CaseError, ValidationError, ValueError), match="a membrane with fibres has no isotropic stretch"):
        case(square("triangles", FIBRES, tension=1.0), **SETTINGS)
