"""What points with linear functions add run by run, against the same point by point."""

import numpy as np
import pytest
from small_cases import GAS, box, place, simulation

from pellucid.approximants.grid_functions import CurvedFunctions, LinearFunctions
from pellucid.grid.particle_to_grid import ParticleToGrid
from pellucid.grid.points import PRESSURE


@pytest.mark.parametrize("full", [False, True])
@pytest.mark.parametrize("transfer", ["flip", "apic"])
@pytest.mark.parametrize("counts", [(3, 2, 4), (1, 5, 4), (9, 1, 1)])
def test_sums_of_runs_are_those_of_points(transfer, counts, full):
    """full: where the pressure of cells acts as a whole, of which points have the rest alone."""
    block = box((0, 0, 0), counts, GAS, cell_pressure=True) if full else box((0, 0, 0), counts)
    sim = simulation(block, counts=counts, transfer=transfer)
    body, rng = sim.bodies[0], np.random.default_rng(3)
    place(body, rng.random((body.n_points, 3)) * counts)  # at random: runs of one point to several, walls included
    for name in ("velocity", "stress", "affine"):
        if name in body.arrays:
            body.arrays[name][:] = rng.normal(size=body.arrays[name].shape)
    assert isinstance(body.mapped.functions, LinearFunctions)
    cells = body._cells
    assert (cells is not None) == full
    if cells is not None:
        cells.found[:, PRESSURE] = rng.normal(size=len(cells.found))
    found, mapped = [], body.mapped.content
    for functions in (mapped.functions, CurvedFunctions(*mapped.functions)):
        sim.stages.clear_nodes()
        points = ParticleToGrid(mapped._replace(functions=functions), body.arrays.get("affine"), cells)
        points.scatter(inertia=True, force=True)
        points.scatter_momentum()
        found.append((sim.grid.nodes.inertia.copy(), sim.grid.nodes.forces.copy()))
    for by_runs, by_points in zip(*found, strict=True):
        assert np.abs(by_points).max() > 0.1
        # sums of some ten points, whose products are rounded in another order
        assert by_runs == pytest.approx(by_points, abs=1e-13 * np.abs(by_points).max())
