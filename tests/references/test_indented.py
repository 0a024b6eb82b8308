"""Indented bodies by finite elements: what must hold between the orders, and the package's linear tetrahedra beside them."""

import pytest

from pellucid.case import load
from pellucid.references import finite_elements
from pellucid.references.solids import indented
from pellucid.simulation.simulation import Simulation


@pytest.mark.parametrize("body", ["cylinder", "heart"])
def test_linear_tetrahedra_lie_above_quadratic_ones(body):
    """Both minimise the energy under the same displacements, quadratic ones among more fields."""
    table = finite_elements.read(f"indented_{body}")
    assert (table["first_energy"] > table["second_energy"]).all()
    assert (table["first_force"] > table["second_force"]).all()


def test_what_was_not_computed_is_none():
    assert indented("cylinder", 389, 0.5).energy == (1.073719e-3, 6.638065e-4)
    assert indented("cylinder", 390, 0.5) is None
    assert indented("cylinder", 389, 0.4) is None


def test_linear_tetrahedra_of_the_package_are_those_of_finite_elements():
    """A quarter of the height deep, to the digits of the table: the same functions, law and conditions by another program, and
    Newton's method instead of dynamic relaxation."""
    linear = {"body.cylinder.approximant": {"kind": "linear-simplex"}, "body.cylinder.volume_averaging": False}
    settings = linear | {"time.end": 0.5, "steady.load_steps": 1, "steady.tolerance": 1e-6, "body.cylinder.points_per_cell": 1}
    simulation = Simulation(load("mountris2019/cylinder-indentation").quick_variant().with_settings(settings), threads=1)
    while not simulation.clock.finished(None):
        simulation.step()
    known = indented("cylinder", simulation.bodies[0].n_points, 0.5)
    assert simulation.budget.energies()["strain"] == pytest.approx(known.energy[0], rel=2e-6)
    assert -simulation.budget.reactions()["indenter"][2] / simulation.time == pytest.approx(known.force[0], rel=2e-6)
