"""What points with linear functions add run by run, against the same point by point."""

import numpy as np
import pytest
from small_cases import GAS, box, place, simulation

from pellucid.approximants.axis import CurvedFunctions, LinearFunctions
from pellucid.grid.points import PRESSURE
from pellucid.grid.transfer import scatter, scatter_momentum
from pellucid.jit.bundle import Bundle


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
    assert (len(body.mapped.cells.found) > 0) == full
    body.mapped.cells.found[:, PRESSURE] = rng.normal(size=len(body.mapped.cells.found))
    found = []
    for mapped in (body.mapped, Bundle(body.mapped._replace(functions=CurvedFunctions(*body.mapped.functions)))):
        sim.stages.clear_nodes()
        scatter(body.n_slabs, mapped, inertia=1, force=1)
        scatter_momentum(body.n_slabs, mapped)
        found.append((sim.grid.nodes.inertia.copy(), sim.grid.nodes.forces.copy()))
    for by_runs, by_points in zip(*found, strict=True):
        assert np.abs(by_points).max() > 0.1
        # sums of some ten points, whose products are rounded in another order
        assert by_runs == pytest.approx(by_points, abs=1e-13 * np.abs(by_points).max())
