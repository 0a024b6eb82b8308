"""Small cases and simulations for tests of the grid, the bodies and the time loop."""

import json

import numpy as np

from pellucid.case import Case
from pellucid.parts.families import GridBody
from pellucid.simulation.simulation import Simulation

SOLID = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 1e4, "poisson_ratio": 0.3}
RATE_SOLID = {"kind": "linear-elastic", "density": 1000.0, "young_modulus": 1e4, "poisson_ratio": 0.3}
GAS = {"kind": "fluid", "density": 1.0, "pressure": 1.0, "eos": {"kind": "ideal-gas", "gamma": 1.4}}
SLIP = [{"where": f"{axis}-{side}", "fix": "normal"} for axis in "xyz" for side in ("lower", "upper")]


def box(lower, upper, material=SOLID, per_cell=(2, 2, 2), name="block", **more):
    """Return the table of a body that fills a box."""
    shape = {"box": {"lower": lower, "upper": upper}}
    return {"name": name, "shape": shape, "points_per_cell": per_cell, "material": material} | more


def case(*bodies, counts=(4, 4, 4), cell=1.0, lower=(0.0, 0.0, 0.0), functions="trilinear", thickness=None, support=(), **more):
    """Return a case with bodies on a grid of `counts` cells. `more` contains keys of the table `time`, and tables whose
    names are keys of a case, such as `load`."""
    table = {name: more.pop(name) for name in Case.model_fields if name in more}
    upper = [a + n * cell for a, n in zip(lower, counts, strict=True)]
    grid = {"lower": lower, "upper": upper, "cell": cell, "functions": functions}
    if thickness is not None:
        grid["thickness"] = thickness
    if "periodic" in more:
        grid["periodic"] = more.pop("periodic")
    time = {"end": 1.0} | more
    return Case.model_validate(
        {"schema": 1, "title": "a test", "grid": grid, "time": time, "body": bodies, "support": support} | table
    )


def shear_flow():
    """Return a case of a gas that flows along the layers of cells that form slabs, so that points mix within slabs and do
    not leave them."""
    wave = {"amplitude": (0, 1.5, 0), "wave_vector": (0, 0, 0.5 * np.pi)}
    gas = box((0, 0, 0), (15, 4, 4), GAS, velocity_wave=wave)
    return case(gas, counts=(15, 4, 4), support=SLIP, end=100.0)


def simulation(*bodies, threads=1, **more):
    """Return the simulation of a case with these bodies and the keys of `case`."""
    return Simulation(case(*bodies, **more), threads=threads)


def place(body, position):
    """Set the positions of the points or nodes of a body [m], shape (n, 3), and sort them."""
    assert body.arrays["position"].shape == np.shape(position)
    body.arrays["position"][:] = position
    (body.storage if isinstance(body, GridBody) else body.coupling).sort()


def advance(sim, steps):
    """Advance a simulation by several steps, and return it."""
    for _ in range(steps):
        sim.step()
    return sim


def finished(sim):
    """Advance a simulation to the end of its case, and return it."""
    while not sim.clock.finished(None):
        sim.step()
    return sim


def to_the_end(case, threads=1):
    """Run a case, and return its simulation at the end."""
    return finished(Simulation(case, threads=threads))


def copied_state(sim):
    """Return copies of the arrays of a checkpoint of a simulation, by name."""
    return {name: array.copy() for name, array in sim.state_arrays().items()}


def assert_resumes(one, again, before, after):
    """Advance `one`, restore its state in `again` by way of JSON, advance both, and compare their arrays bit by bit."""
    advance(one, before)
    again.restore(copied_state(one), json.loads(json.dumps(one.state_numbers())))
    assert_same_arrays(copied_state(advance(one, after)), copied_state(advance(again, after)))


def past_a_disc(end, **keys):
    """A periodic row of discs in a slow flow, which a force drives; keys: of the material of the liquid."""
    material = {"kind": "fluid", "density": 1.0, "viscosity": 1.0, "implicit_pressure": True}
    material |= {"eos": {"kind": "tait", "sound_speed": 10.0, "carries_tension": True}}
    body = box((0, 0, 0), (1, 1, 1 / 24), material | keys, (2, 2, 1), "water")
    how = {"counts": (24, 24, 1), "cell": 1 / 24, "functions": "quadratic-bspline", "transfer": "apic", "scheme": "usl"}
    disc = {"where": {"cylinder": {"centre": (0.5, 0.5, 0), "radius": 0.16}}}
    force = [{"kind": "body-force", "body": "water", "acceleration": (4, 0, 0)}]
    return simulation(body, **how, periodic=["x", "y"], support=[disc], load=force, end=end)


def assert_same_arrays(one, two):
    """Check that two sets of arrays by name are equal, bit for bit."""
    assert one.keys() == two.keys()
    for name, array in one.items():
        assert np.array_equal(array, two[name]), name
