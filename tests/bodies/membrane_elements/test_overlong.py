"""Elements that grew longer than cells allow are told where they touch others."""

import warnings

import numpy as np
import pytest
from elements import body_of, bring, element_sheet, places
from membranes import sheet
from small_cases import advance, box, simulation

from pellucid.bodies.own_nodes.contact_surface import LONGEST_EDGE
from pellucid.contact.surface_pairs import SurfacePairs


def stretched(times, **more):
    """A square sheet of 6 by 6 elements of 2/3 of a cell, of which x grew by a factor."""
    body = body_of(element_sheet(**more))
    bring(body, places(body) * (times, 1.0, 1.0))
    return body


def everywhere(body):
    return np.arange(body.grid.n_nodes)


@pytest.mark.parametrize("elements", ["quads", "triangles"])
def test_elements_up_to_the_limit_pass(elements):
    side = 1.0 / 6.0 / 0.25  # cells
    diagonal = (side * side + (1.4 * side) ** 2) ** 0.5
    assert (1.4 * side if elements == "quads" else diagonal) < LONGEST_EDGE
    body = stretched(1.4, elements=elements)
    assert body.contact_warning(everywhere(body)) is None


def test_longer_ones_are_named_with_place_and_length():
    body = stretched(2.4)  # to 1.6 cells
    text = body.contact_warning(everywhere(body))
    assert "body sheet" in text
    assert "is 0.4 m long, 1.6 cells of 0.25 m" in text
    assert "refine the elements, or use a larger grid.cell" in text


def test_only_those_that_touch_count():
    body = stretched(2.4)
    corners = places(body)[body.surface.mesh.corners]
    chosen = 13
    lattice = body.grid.lattice
    node = np.floor((corners[chosen].mean(axis=0) - lattice.lower) / lattice.cell).astype(int) @ lattice.strides
    assert body.contact_warning(np.zeros(0, np.int64)) is None
    text = body.contact_warning(np.array([node]))
    named = int(text.split("its element ")[1].split()[0])
    assert np.abs(corners[named].mean(axis=0) - corners[chosen].mean(axis=0)).max() < 2 * lattice.cell
    far = np.floor((np.array([-1.9, -1.9, -1.9]) - lattice.lower) / lattice.cell).astype(int) @ lattice.strides
    assert body.contact_warning(np.array([far])) is None


def falling_on(stiffness, steps=600):
    """A run in which a block falls on a sheet of elements as long as a cell, held at its sides."""
    own = sheet(edges=((6, 0, 0), (0, 6, 0)), points=(7, 7), kind="membrane-elements", field="own")
    own["surface"]["rectangle"]["corner"] = (2.0, 2.0, 6.0)
    own["material"] |= {"density": 10.0, "young_modulus": stiffness}
    block = box((4, 4, 6.1), (6, 6, 7.1), velocity=(0, 0, -1))
    sides = [((1.9, 1.9), (2.1, 8.1)), ((7.9, 1.9), (8.1, 8.1))]
    motion = [
        {"name": name, "body": "sheet", "hold": ["x", "y", "z"], "part": {"box": {"lower": [*low, 5.9], "upper": [*high, 6.1]}}}
        for name, (low, high) in zip("ab", sides, strict=True)
    ]
    quiet = {"warn": 1e3, "stop": 1e4}
    sim = simulation(own, block, counts=(10, 10, 8), motion=motion, step=0.005, end=10.0, energy=quiet)
    advance(sim, steps)
    return sim


def test_a_run_tells_once_and_remembers_that_it_did():
    with pytest.warns(UserWarning, match="step [0-9]*00, .*where body sheet touches another") as told:
        sim = falling_on(stiffness=10.0)
    assert len([each for each in told if "touches another" in str(each.message)]) == 1
    between = [str(each.message) for each in told if "can pass between the nodes" in str(each.message)]
    assert len(between) == 1, "the sheet was stretched so far that the block may pass"
    late = falling_on(stiffness=10.0, steps=0)
    late.restore({name: array.copy() for name, array in sim.state_arrays().items()}, sim.state_numbers())
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        advance(late, 100)


def test_a_run_with_short_elements_says_nothing_of_them():
    """Nor that contact gives energy, though nodes of the sheet lie beneath the rim of the block, which is two elements wide."""
    with warnings.catch_warnings():
        warnings.filterwarnings("error", ".*touches another")
        warnings.filterwarnings("error", ".*contact between surfaces")
        sim = falling_on(stiffness=4e4, steps=400)
    assert abs(sim.parts.only(SurfacePairs).energy.unexplained) < 0.01 * sim.budget.energy_scale
    assert sim.bodies[0].arrays["position"][:, 2].min() < 4.5, "it carries the block down, and its elements grow by a fifth"
