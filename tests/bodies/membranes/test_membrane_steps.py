"""The steps of membranes of every kind: those of plane stress at rest, and stable where the membrane is stretched."""

import numpy as np
import pytest
from elements import DENSITY, bring_to, element_sheet, fastest_frequency, single_element
from membranes import RIM, THICKNESS, E, assert_stable_when_shaken, edge, neo_hookean_stretch, sheet
from small_cases import simulation

from pellucid.materials.elastic import ElasticMembraneMaterial
from pellucid.materials.membrane_material import MEMBRANE_MATERIALS

LAWS = [kind for kind, model in MEMBRANE_MATERIALS.entries.items() if issubclass(model, ElasticMembraneMaterial)]
KINDS = {
    "points": {"kind": "membrane-points"},
    "quadrilaterals": {"kind": "membrane-elements"},
    "triangles": {"kind": "membrane-elements", "elements": "triangles"},
}
every_kind = pytest.mark.parametrize("kind", KINDS)
SETTINGS = {"counts": (14, 10, 8), "cell": 0.25, "lower": (-1.0, -1.25, -1.0), "functions": "quadratic-bspline", "end": 100.0}


def square(kind, law, ratio=0.3, n=11, **more):
    """A square of 1 m about the origin, in z = 0."""
    table = sheet(law) | KINDS[kind] | {"name": "sheet"} | more
    table["surface"] = {
        "rectangle": {"corner": [-0.5, -0.5, 0], "first_edge": (1, 0, 0), "second_edge": (0, 1, 0), "points": (n, n)}
    }
    table["material"] = table["material"] | {"poisson_ratio": ratio}
    return table


# half the largest eigenfrequency over the speed of waves: 1/h of cells, and of square elements and their halves as in the sheet
REACH = {"points": 4.0, "quadrilaterals": 10.0 * np.sqrt(2.0), "triangles": 10.0 * np.sqrt(3.0)}


@every_kind
@pytest.mark.parametrize("ratio", [0.3, 0.49])
def test_at_rest_all_laws_have_the_step_of_plane_stress(kind, ratio):
    rates = [simulation(square(kind, law, ratio), **SETTINGS).bodies[0].totals.rate for law in LAWS]
    speed = np.sqrt(E / ((1.0 - ratio**2) * DENSITY))
    assert rates == pytest.approx([REACH[kind] * speed] * len(LAWS), rel=1e-9)


@every_kind
@pytest.mark.parametrize("ratio", [0.3, 0.49])
def test_a_sheet_stretched_twofold_both_ways_is_stable(kind, ratio):
    stress, _ = neo_hookean_stretch((2.0, 2.0), ratio)
    tense = square(kind, "neo-hookean-membrane", ratio, tension=stress[0] * THICKNESS)
    assert_stable_when_shaken(simulation(tense, motion=RIM, courant=0.8, **SETTINGS))


@pytest.mark.parametrize("kind", ["quadrilaterals", "triangles"])
@pytest.mark.parametrize("ratio", [0.3, 0.49])
def test_elements_pulled_to_twice_their_length_are_stable(kind, ratio):
    """Their sides are free; the step follows the stiffness on the way."""
    pulled = edge(
        "right", (0.5, 0.5), (-0.5, 0.5), hold="yz", displacement={"x": {"kind": "ramp", "distance": 1.0, "duration": 0.3}}
    )
    sim = simulation(square(kind, "neo-hookean-membrane", ratio), motion=[RIM[0], pulled], courant=0.8, **SETTINGS)
    while sim.time < 0.3:
        sim.step()
    assert sim.bodies[0].arrays["position"][:, 0].max() == pytest.approx(1.5, abs=1e-6)
    assert_stable_when_shaken(sim)


@pytest.mark.filterwarnings("ignore:.*energy error")  # of what moves: the energy that the stretch took is not in the balance
@pytest.mark.parametrize("ratio", [0.3, 0.49])
def test_points_stretched_twofold_one_way_are_stable(ratio):
    sim = simulation(square("points", "neo-hookean-membrane", ratio), motion=RIM, courant=0.8, **SETTINGS)
    body = sim.bodies[0]
    body.arrays["in_plane"][:, 0] = 2.0
    body.arrays["mass"] *= 0.5  # of half the length
    body.renew_totals()
    assert_stable_when_shaken(sim)


@pytest.mark.parametrize("kind", ["quadrilaterals", "triangles"])
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("stretches", [(1.0, 1.0), (2.0, 1.0), (1.5, 1.5)])
def test_no_element_swings_faster_than_its_bound(kind, law, stretches):
    """Against the largest eigenfrequency by differences of the forces on its corners."""
    body = single_element(element_sheet(law), kind)
    bring_to(body, stretches)
    assert 1.0 <= 2.0 * body.totals.rate / fastest_frequency(body) < 2.0
