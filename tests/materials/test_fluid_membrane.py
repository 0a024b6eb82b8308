"""The law of membranes that are fluid within their surface."""

import numpy as np
import pytest
from membranes import THICKNESS, body_of, drive, sheet
from pydantic import ValidationError

from pellucid.materials.fluid_membrane import FluidMembraneMaterial
from pellucid.materials.membrane import plane_response, stretched, wave_in_shape

PARAMETERS = {"density": 1000.0, "tension": 3e3, "stiffness": 2e4, "viscosity": 50.0, "dilatational_viscosity": 20.0}


def material(**more):
    return FluidMembraneMaterial.model_validate({"kind": "fluid-membrane"} | PARAMETERS | more)


def fluid_sheet(**more):
    return sheet(material={"kind": "fluid-membrane"} | PARAMETERS | more)


@pytest.mark.parametrize("area", [0.7, 1.0, 1.9])
def test_the_tension_is_what_the_energy_costs(area):
    """dW/dA of unit initial area is the force in the surface; stress times thickness ratio is that over the thickness."""
    of, h = material(), 1e-5
    energies = of.recoverable_energy(np.array([[a, 0.0, 0.0, 0.0] for a in (area - h, area + h)])) * of.density
    s11, s22, s12, ratio = plane_response(of.law(1.0), (area, 0.0, 0.0, 0.0))
    assert s11 * ratio == pytest.approx(float(energies[1] - energies[0]) / (2.0 * h), rel=1e-8)
    assert (s22, s12) == (s11, 0.0)
    assert ratio * area == pytest.approx(1.0)


def test_viscous_stress_follows_the_rates():
    """σ = (λ tr D) I + 2μ D, times the area: the force in the surface is that over the thickness at the start."""
    law, D = material(tension=0.0, stiffness=0.0).law(1.0), (0.3, -0.1, 0.2)
    shape = stretched(law, (1.0, 0.0, 0.0, 0.0), D, 1e-12)
    assert plane_response(law, shape)[:3] == pytest.approx((20.0 * 0.2 + 100.0 * 0.3, 20.0 * 0.2 - 100.0 * 0.1, 100.0 * 0.2))


def test_shear_leaves_no_stress_behind():
    grid, body = body_of(fluid_sheet(viscosity=0.0, dilatational_viscosity=0.0))
    drive(grid, body, [[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]], 0.01, 100)
    stress, middle = body.frame()["stress"], np.abs(body.frame()["position"][:, 1] - 0.02) < 0.3
    assert stress[middle, :2] == pytest.approx(PARAMETERS["tension"], rel=1e-9)
    assert np.abs(stress[middle, 3:]).max() < 1e-9 * PARAMETERS["tension"]


def test_work_is_stored_or_dissipated_as_the_law_says():
    """A sheet of fluid stretched at a steady rate along x: what is not stored is heat, to first order in the step."""
    rate, end, errors = 0.2, 1.0, []
    for steps in (100, 200):
        dt = end / steps
        grid, body = body_of(fluid_sheet())
        drive(grid, body, np.diag([rate, 0.0, 0.0]), dt, steps)
        area = (1.0 + rate * dt) ** steps
        stored = 1000.0 * THICKNESS * float(material().recoverable_energy(np.array([[area, 0.0, 0.0, 0.0]]))[0])
        # (2μ + λ) rate² of the area that there is, over the thickness at the start
        heat = (2.0 * 50.0 + 20.0) * rate * (area - 1.0) * THICKNESS
        lost = body.totals.parts["dissipated"]
        assert body.totals.stored - lost == pytest.approx(stored, rel=1e-12)
        errors.append(abs(lost - heat) / stored)
    assert errors[0] < rate * end / 100.0
    assert errors[1] == pytest.approx(0.5 * errors[0], rel=0.05)


def test_its_viscosity_bounds_the_step():
    slow = body_of(fluid_sheet(viscosity=0.0, dilatational_viscosity=0.0))[1].totals.rate
    fast = body_of(fluid_sheet(viscosity=1e6))[1].totals.rate
    assert slow == pytest.approx(wave_in_shape(material().law(1.0), (1.0, 0.0, 0.0, 0.0), 1000.0) / 0.25)
    assert fast == pytest.approx(2.0 * (2e6 + 20.0) / 1000.0 / 0.25**2)


def test_a_film_that_bears_nothing_is_refused():
    nothing = dict.fromkeys(("tension", "stiffness", "viscosity", "dilatational_viscosity"), 0.0)
    with pytest.raises(ValidationError, match="needs a tension, a stiffness or a viscosity"):
        material(**nothing)
