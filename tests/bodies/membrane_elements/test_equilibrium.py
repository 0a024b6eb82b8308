"""Energy, forces and stiffness of membranes of triangles at trial positions."""

import numpy as np
import pytest
from membranes import SURFACE_LAWS
from scipy.integrate import quad

from pellucid.case import Case
from pellucid.materials.law import energy
from pellucid.materials.linear_membrane import LinearMembrane
from pellucid.materials.membrane import plane_response
from pellucid.simulation.simulation import Simulation

SPHERE = {"sphere": {"centre": [0, 0, 0], "radius": 0.1, "divisions": 3}}
SHEET = {"rectangle": {"corner": [0, 0, 0], "first_edge": [0.2, 0, 0], "second_edge": [0, 0.1, 0], "points": [5, 4]}}
ELASTIC = {"density": 1000.0, "young_modulus": 1e6, "poisson_ratio": 0.3}
NEO, LINEAR = ({"kind": kind} | ELASTIC for kind in ("neo-hookean-membrane", "linear-membrane"))
LAWS = [NEO, LINEAR, *({"kind": kind, "density": 1000.0} | keys for kind, keys in SURFACE_LAWS.items())]
BENT = {"bending": {"rigidity": 1e-3}}
KEPT = {"area_stiffness": 300.0, "volume_stiffness": 2e4}
PRESSURE = 500.0


def system_of(surface=SPHERE, material=NEO, pressure=0.0, **more):
    """The simulation, the body, and its system with a pressure that follows it."""
    skin = {"name": "skin", "kind": "membrane-elements", "elements": "triangles", "thickness": 1e-3, "material": material}
    table = {"schema": 1, "title": "a test", "time": {"end": 1.0}, "steady": {}, "pressure": [{"body": "skin", "value": 1.0}]}
    simulation = Simulation(Case.model_validate(table | {"body": [skin | {"surface": surface} | more]}), threads=1)
    (body,) = simulation.bodies
    system = body.elastic_system()
    system.begin(1.0)

    def renew(share):
        body.begin(1.0)
        body.surface.add_pressure_forces(body.arrays["position"], share * pressure, body.motion.loads[0])

    renew(1.0)
    system.take_loads(renew, pressure != 0.0)
    return body, system


def strained(body, size=0.1):
    """Positions under a stretch of a fifth and random displacements."""
    rng = np.random.default_rng(5)
    x = body.surface.vertices
    return 1.2 * x @ (np.eye(3) + size * rng.uniform(-1.0, 1.0, (3, 3))) + 0.01 * size * rng.normal(size=x.shape)


SHAPES = {
    "sphere": (SPHERE, {}),
    "bent sphere": (SPHERE, BENT),
    "kept sphere": (SPHERE, KEPT),
    "sheet": (SHEET, {}),
    "plate": (SHEET, BENT),
}
every_shape = pytest.mark.parametrize("shape", SHAPES)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law["kind"])
def test_forces_are_the_slope_of_the_energy(law):
    """For laws without an energy at large strains the difference is of the third order of the strain."""
    body, system = system_of(SHEET, law)
    x, way, step = strained(body), np.random.default_rng(6).normal(size=body.surface.vertices.shape), 1e-7
    ahead, behind = (system.attempt(x + size * way).energy for size in (step, -step))
    here = system.attempt(x)
    assert here.is_valid
    near = 1e-6 if system.has_potential else 0.5
    assert -np.sum(here.residual * way) == pytest.approx((ahead - behind) / (2.0 * step), rel=near)
    assert system.has_potential == (law is not LINEAR)


def test_the_energy_is_that_of_the_state_not_of_the_way():
    body, system = system_of(SHEET, **BENT)
    x = strained(body)
    first = system.attempt(x).energy
    system.attempt(strained(body, 0.3))
    assert system.attempt(x).energy == first
    assert system.attempt(body.surface.vertices).energy == pytest.approx(0.0, abs=1e-15)


def test_a_trial_out_of_all_bounds_leaves_no_trace():
    body, system = system_of()
    first = system.attempt(strained(body)).energy
    assert not system.attempt(1e200 * strained(body)).is_valid
    assert system.attempt(strained(body)).energy == first


@every_shape
@pytest.mark.parametrize("pressure", [0.0, PRESSURE])
def test_displacements_follow_from_forces(shape, pressure):
    """The change of all forces under a displacement of the nodes gives it back, also that of a pressure, which follows the
    nodes. The pressure acts on a closed surface, or on one whose rim is held: there its stiffness is symmetric."""
    surface, keys = SHAPES[shape]
    body, system = system_of(surface, pressure=pressure, **keys)
    system._share = 1.0
    places = body.surface.vertices
    rim = np.isclose(places, places.min(axis=0)) | np.isclose(places, places.max(axis=0))
    free = ~(rim[:, :2].any(axis=1) | (places[:, 2] < -0.09))[:, None] & np.ones(3, bool)
    x = strained(body, 0.02)
    if surface is SHEET:  # bulged, not folded
        x = 1.2 * places + 0.02 * np.sin(20.0 * places[:, :1] + 1.0) * [0.0, 0.0, 1.0]
    moved = np.random.default_rng(7).normal(size=x.shape) * free
    step = 1e-7

    def forces(position):
        trial = system.attempt(position)
        assert trial.is_valid
        return body.motion.forces().copy()

    change = (forces(x - step * moved) - forces(x + step * moved)) / (2.0 * step)
    forces(x)
    matrix = system._new_stiffness()
    matrix.renew(free, x, single=False)
    assert matrix.shift == 0.0
    assert matrix.solve(change) == pytest.approx(moved, abs=1e-5)
    given = np.random.default_rng(8).normal(size=x.shape) * ~free
    found, resisted = matrix.follow(np.zeros_like(x), given)
    assert found[~free] == pytest.approx(given[~free])
    assert abs(resisted[free]).max() < 1e-9 * abs(resisted).max()


def test_a_flat_membrane_has_no_stiffness_across():
    body, system = system_of(SHEET)
    system.attempt(body.surface.vertices.copy())
    matrix = system._new_stiffness()
    matrix.renew(np.ones((20, 3), bool), body.surface.vertices, single=True)
    assert matrix.shift > 0.0


@pytest.mark.parametrize("strain", [(0.2, -0.1, 0.05), (-0.3, -0.2, 0.1), (1e-6, 0.0, 0.0)])
def test_the_energy_of_small_strains_is_the_work_of_straining_in_proportion(strain):
    law, e = LinearMembrane(2e6, 0.3), np.array(strain)

    def power(share):
        s11, s22, s12, ratio = plane_response(law, (*(share * e), 0.0))
        return ratio * np.exp(share * (e[0] + e[1])) * (s11 * e[0] + s22 * e[1] + 2.0 * s12 * e[2])

    assert energy(law, (*e, 0.0)) == pytest.approx(quad(power, 0.0, 1.0, epsabs=0.0)[0], rel=1e-6)
