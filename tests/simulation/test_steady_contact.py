"""Steady states with contact by surfaces: no overlap is left, friction does not depend on the relaxation, rigid tools."""

import numpy as np
import pytest

from pellucid.case import Case
from pellucid.results.storage.probes import ProbeReader
from pellucid.simulation.simulation import Simulation

E, NU, EDGE, DOWN = 1000.0, 0.3, 0.1, 0.01
SOFT = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": E, "poisson_ratio": NU}
HARD = {"kind": "linear-elastic", "density": 1000.0, "young_modulus": 1e6, "poisson_ratio": NU}
PLANES = ["x-lower", "y-lower", "z-lower"]
PRESS = {"kind": "steady", "velocity": -DOWN}
GRID = {"lower": (0.0, 0.0, 0.0), "upper": (0.2, 0.2, 0.25), "cell": 0.025}
HELD = {"name": "press", "body": "tool", "hold": ["x", "y"], "hold_rotation": ["x", "y", "z"], "displacement": {"z": PRESS}}


def block(lower=0.0, upper=EDGE, name="block", cells=2, **more):
    """A block of two cells along the edges, or more."""
    mesh = {"box": {"lower": (0.0, 0.0, lower), "upper": (EDGE, EDGE, upper), "cells": (cells, cells, cells)}}
    return {"name": name, "field": name, "kind": "meshless-solid", "mesh": mesh, "material": SOFT} | more


def tool(bottom=EDGE, **more):
    """A rigid slab above a block."""
    shape = {"box": {"lower": (0.0, 0.0, bottom), "upper": (0.15, 0.15, bottom + 0.05)}}
    body = {"name": "tool", "field": "tool", "kind": "material-points", "rigid": True, "shape": shape, "material": HARD}
    body["points_per_cell"] = 1
    return body | more


def wall(height=EDGE, **more):
    return {"name": "press", "point": (0.0, 0.0, height), "normal": (0.0, 0.0, -1.0), "velocity": (0.0, 0.0, -DOWN)} | more


def table(bodies, steady=None, **more):
    """A case with planes of symmetry, whose loads end at 1 s."""
    support = more.pop("support", [{"where": PLANES, "fix": "normal", "name": "planes"}])
    steady = {"tolerance": 1e-6} | (steady or {})
    general = {"schema": 1, "title": "a test", "time": {"end": 1.0}, "grid": GRID, "steady": steady}
    return general | {"body": bodies, "support": support} | more


def finished(data):
    """The simulation at its end and the probes of each equilibrium."""
    case = Case.model_validate(data)
    simulation, rows = Simulation(case, threads=1), []
    reader = ProbeReader(case.probe)
    while not simulation.clock.finished(None):
        before = simulation.time
        simulation.step()
        if simulation.time > before:
            rows.append(reader.read(simulation.bodies, simulation.budget.reactions(), simulation.time))
    return simulation, np.array(rows)


def probes(*components, name="press"):
    return [{"name": c, "quantity": "reaction", "condition": name, "component": c} for c in components]


def overlaps(simulation, height=EDGE - DOWN):
    """How far points on the upper side of the first body lie beyond a height [m]: in the mean, and the farthest either way."""
    surface = simulation.bodies[0].contact_surface
    beyond = surface.place[surface.normals()[:, 2] > 0.9, 2] - height
    return abs(beyond.mean()), abs(beyond).max()


@pytest.fixture(scope="module")
def led():
    """Force on a block whose upper nodes are led by as much, and which is free to become wider [N]."""
    top = {"box": {"lower": (-1.0, -1.0, EDGE - 1e-4), "upper": (1.0, 1.0, 1.0)}}
    motion = {"name": "press", "body": "block", "part": top, "displacement": {"z": PRESS}}
    return finished(table([block()], motion=[motion], probe=probes("z")))[1][-1, 0]


ONE = {
    "wall": {"wall": [wall()], "body": [block()]},
    "tool": {"motion": [HELD], "body": [block(), tool()]},
    "driven points": {
        "motion": [{"name": "press", "body": "tool", "hold": ["x", "y"], "displacement": {"z": PRESS}}],
        "body": [block(), tool(rigid=False)],
    },
}


@pytest.mark.parametrize("kind", ONE)
def test_a_block_under_a_flat_tool_is_compressed_as_if_its_nodes_were_led(led, kind):
    """No overlap is left: that of the springs alone would be a tenth of the displacement."""
    parts = dict(ONE[kind])
    simulation, rows = finished(table(parts.pop("body"), {"load_steps": 2}, probe=probes("z"), **parts))
    assert abs(rows[-1, 0]) == pytest.approx(abs(led), rel=5e-3)
    mean, most = overlaps(simulation)
    assert mean < 5e-4 * DOWN
    assert most < 2e-2 * DOWN
    assert abs(simulation.budget.conservation()["energy"]) < 1e-2


@pytest.mark.parametrize(
    ("steady", "density"), [({"courant": 0.4}, 1e3), ({"mass_scaling": True}, 1e3), ({"loading": 300}, 1e3), ({}, 7e4)]
)
def test_the_force_depends_neither_on_the_step_nor_on_inertia(led, steady, density):
    bodies = [block(material=SOFT | {"density": density})]
    _, rows = finished(table(bodies, steady, wall=[wall()], probe=probes("z")))
    assert abs(rows[-1, 0]) == pytest.approx(abs(led), rel=5e-3)


def test_two_blocks_on_each_other_are_compressed_like_one(led):
    """Both deform, the one with smaller elements: each by a half."""
    bodies = [block(), block(EDGE, 2.0 * EDGE, "upper", 3)]
    simulation, rows = finished(table(bodies, wall=[wall(2.0 * EDGE, velocity=(0.0, 0.0, -2.0 * DOWN))], probe=probes("z")))
    assert abs(rows[-1, 0]) == pytest.approx(abs(led), rel=5e-3)
    assert overlaps(simulation)[0] < 1e-2 * DOWN


@pytest.mark.parametrize("first", ["block", "punch"])
def test_edges_of_the_smaller_of_two_bodies_do_not_sink_in(first):
    """A block on a wider one with equally fine surfaces, in either order. Where the wider one searched, the edges of the other
    sank in by 8 % of the displacement, and the force was smaller by 3 %."""
    mesh = {"box": {"lower": (0.0, 0.0, EDGE), "upper": (0.05, 0.05, 2.0 * EDGE), "cells": (2, 2, 4)}}
    below = {"box": {"lower": (0.0, 0.0, 0.0), "upper": (EDGE, EDGE, EDGE), "cells": (2, 2, 4)}}
    bodies = [block(mesh=below), block(name="punch", mesh=mesh)]
    data = table(bodies if first == "block" else bodies[::-1], wall=[wall(2.0 * EDGE, velocity=(0.0, 0.0, -2.0 * DOWN))])
    simulation, _ = finished(data)
    lower, upper = (body.contact_surface for body in sorted(simulation.bodies, key=lambda body: body.name))
    bottom = upper.place[upper.normals()[:, 2] < -0.9]
    top = lower.place[lower.normals()[:, 2] > 0.9]
    for x, y, z in bottom:
        nearest = top[np.hypot(top[:, 0] - x, top[:, 1] - y).argmin()]
        assert nearest[2] - z < 0.06 * DOWN


def test_a_nearly_incompressible_block_has_no_overlap_either():
    """Its inertia of volume allows long steps, and contact springs that are soft beside the block."""
    bodies = [block(material=SOFT | {"poisson_ratio": 0.4999})]
    simulation, _ = finished(table(bodies, {"method": "relaxation"}, wall=[wall()]))
    assert overlaps(simulation)[0] < 5e-3 * DOWN
    assert simulation.bodies[0]._volume_inertia is not None
    assert simulation.n_steps < 6000


def dragged(load_steps=2, along=0.03, **steady):
    """Forces of a wall that presses in the first half of the loads and goes along the block as well, at each equilibrium."""
    foot = {"body": "block", "where": {"box": {"lower": (-1.0, -1.0, -1.0), "upper": (1.0, 1.0, 1e-4)}}, "name": "foot"}
    moving = wall(velocity=(along, 0.0, -DOWN), kind="coulomb", friction=0.2)
    steady = {"load_steps": load_steps} | steady
    data = table([block()], steady, wall=[moving], probe=probes("x", "z"), support=[foot])
    data["grid"] = {"lower": (-0.1, -0.1, 0.0), "upper": (0.25, 0.25, 0.25), "cell": 0.025}
    return finished(data)[1]


def test_friction_does_not_depend_on_the_way_of_the_relaxation():
    """Parts of the block slide and others stick; loads that grow faster overshoot more."""
    slow, fast = dragged(loading=800), dragged(loading=120)
    assert abs(slow[:, 0]) == pytest.approx(abs(fast[:, 0]), rel=5e-3)
    assert (abs(slow[:, 0]) <= 0.2 * abs(slow[:, 1]) * 1.001).all()


def test_a_wall_that_slides_drags_with_the_coefficient_of_friction():
    rows = dragged(along=0.2)
    assert abs(rows[:, 0]) == pytest.approx(0.2 * abs(rows[:, 1]), rel=1e-3)


def test_it_goes_on_from_a_checkpoint_bit_for_bit():
    data = table([block()], {"load_steps": 2, "method": "relaxation"}, wall=[wall(kind="coulomb", friction=0.3)])
    case = Case.model_validate(data)
    whole = Simulation(case, threads=1)
    while not (whole.clock._corrections == 2 and whole.time > 0.0):
        whole.step()
    parts = Simulation(case, threads=1)
    arrays = {name: array.copy() for name, array in whole.state_arrays().items()}
    parts.restore(arrays, whole.state_numbers())
    for _ in range(60):
        whole.step()
        parts.step()
    assert whole.clock.time == parts.clock.time
    assert (whole.bodies[0].arrays["position"] == parts.bodies[0].arrays["position"]).all()


def refused(data):
    with pytest.raises(ValueError, match="steady") as caught:
        Case.model_validate(data)
    return str(caught.value)


def test_rigid_bodies_that_motions_do_not_prescribe_are_refused():
    assert "free along x, y, z" in refused(table([block(), tool()]))
    partly = {"name": "press", "body": "tool", "hold": ["x"], "displacement": {"z": PRESS}}
    assert "free along y" in refused(table([block(), tool()], motion=[partly]))
    turning = HELD | {"hold_rotation": ["x"]}
    assert "free to rotate about y, z" in refused(table([block(), tool()], motion=[turning]))
    assert "all bodies of the case are rigid" in refused(table([tool()], motion=[HELD]))


def test_a_tool_without_a_word_about_its_rotation_is_held_with_a_warning(led):
    motion = {name: value for name, value in HELD.items() if name != "hold_rotation"}
    with pytest.warns(UserWarning, match="constrains the rotation about x, y, z"):
        _, rows = finished(table([block(), tool()], motion=[motion], probe=probes("z")))
    assert abs(rows[-1, 0]) == pytest.approx(abs(led), rel=5e-3)


LIQUIDS = {
    "volume-stiffness": {},
    "enclosed": {
        "enclosed": [{"name": "cytoplasm", "body": "zona", "liquid": {"pressure": 0.0, "bulk_modulus": 1e6, "density": 1000.0}}]
    },
}


@pytest.mark.slow
@pytest.mark.parametrize("liquid", LIQUIDS)
def test_an_oocyte_between_two_walls(liquid):
    """A membrane full of liquid on 642 nodes; forces of a membrane between plates, from the energy of a chain of cones.

    The surface of the facets encloses a little less than the sphere, and their corners touch first.
    """
    walls = [
        {"name": "upper", "point": (0, 0, 54.2e-6), "normal": (0, 0, -1), "velocity": (0, 0, -1e-6)},
        {"name": "lower", "point": (0, 0, -54.2e-6), "normal": (0, 0, 1), "velocity": (0, 0, 1e-6)},
    ]
    zona = {
        "name": "zona",
        "kind": "membrane-elements",
        "elements": "triangles",
        "surface": {"icosphere": {"centre": (0, 0, 0), "radius": 50e-6, "refinements": 3}},
        "thickness": 8e-6,
        "inflation": 0.02,
        "material": {"kind": "neo-hookean-membrane", "density": 1100, "young_modulus": 17.9e3, "poisson_ratio": 0.49},
    } | ({} if LIQUIDS[liquid] else {"volume_stiffness": 1e6})
    axis = {"body": "zona", "where": {"cylinder": {"centre": (0, 0, 0), "radius": 2e-6, "height": 120e-6}}, "fix": ["x", "y"]}
    table_of = {"schema": 1, "title": "a test", "wall": walls, "body": [zona], "support": [axis]} | LIQUIDS[liquid]
    table_of |= {"grid": {"lower": (-90e-6, -90e-6, -60e-6), "upper": (90e-6, 90e-6, 60e-6), "cell": 10e-6}}
    start = Simulation(Case.model_validate(table_of | {"time": {"end": 1.0}, "steady": {}}), threads=1)
    touch = 54.2e-6 - 50e-6 - start.bodies[0].contact_surface.half_width  # of the thickness at rest, without the inflation
    times = np.array([2.0, 4.0, 8.0, 12.0, 16.0]) + touch * 1e6
    table_of |= {"time": {"end": times[-1]}, "steady": {"tolerance": 1e-3, "at": times[:-1].tolist()}}
    _, rows = finished(table_of | {"probe": probes("z", name="upper")})
    assert -rows[:, 0] == pytest.approx(np.array([58.57, 157.15, 471.4, 1001.7, 1864.4]) * 1e-9, rel=0.025)
