"""Meshless solids of every hyperelastic law: forces, a uniform strain, and a block that is thrown."""

import re

import numba
import numpy as np
import pytest
from samples import HYPERELASTIC, USERS
from solids import block, thrown

from pellucid.bodies.meshless_solid.forces import _elastic_stresses, in_kernels, internal_forces
from pellucid.bodies.meshless_solid.functions import make_tables
from pellucid.bodies.meshless_solid.solid import CHUNK, COLUMN, COLUMNS, ENERGY
from pellucid.jit.registry import IN_KERNELS
from pellucid.materials.law import energy
from pellucid.simulation.simulation import Simulation

NEW = [name for name in HYPERELASTIC if name != "neo-hookean" and name not in USERS]


@pytest.mark.parametrize("name", NEW)
def test_forces_are_the_derivative_of_the_energy_with_averaged_volume_ratios(name):
    case = block(HYPERELASTIC[name].model_dump()).body[0]
    assert case.averages_volume, "at a Poisson's ratio of 0.45"
    law = case.law()
    mesh = case.mesh_in_order()
    solid = make_tables(mesh, case.approximant.evaluator(mesh), law, 4, True, True).solid
    nodes, bundle = mesh.nodes, in_kernels(solid)

    def forces(u):
        found = np.zeros_like(nodes)
        solid.displacement[:] = u
        internal_forces(len(solid.sums), (len(nodes) + CHUNK - 1) // CHUNK, bundle, 0.0, False, found)
        return found, solid.sums[:, ENERGY].sum() + solid.node_sums[:, ENERGY].sum()

    numbers = np.random.default_rng(3)
    G = np.array([[0.2, 0.05, 0.0], [0.0, -0.2, 0.1], [0.05, 0.0, 0.15]])
    u, along = nodes @ G.T + numbers.uniform(-2e-3, 2e-3, nodes.shape), numbers.uniform(-1.0, 1.0, nodes.shape)
    step = 1e-7  # central differences of a smooth energy: an error of (step/spacing)² and of rounding over step
    work = (forces(u + step * along)[1] - forces(u - step * along)[1]) / (2.0 * step)
    assert -np.sum(forces(u)[0] * along) == pytest.approx(work, rel=1e-6)
    # the patch test: a linear displacement has the energy of its strain
    assert forces(nodes @ G.T)[1] == pytest.approx(1e-3 * energy(law, tuple((np.eye(3) + G).ravel().tolist())), rel=1e-10)


@pytest.mark.parametrize("name", NEW)
def test_a_block_that_is_thrown_keeps_its_energy(name):
    case = thrown(HYPERELASTIC[name].model_dump())
    sim = Simulation(case, threads=1)
    kinetic, strained, errors = sim.bodies[0].totals.kinetic, [], []
    while sim.time < case.time.end:
        sim.step()
        strained.append(sim.bodies[0].totals.stored)
        errors.append(abs(sim.budget.energy_error()))
    assert max(strained) > 0.5 * kinetic
    # of the second order in the step, since `staggering` has the half step between velocities and stresses: 2e-5 to 3e-5
    assert max(errors) < 1e-4
    assert np.isfinite(sim.bodies[0].field("stress")).all()


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_principal_stretches_of_several_points_are_found_at_a_time():
    """Whatever their deformation, without a branch or a call."""
    options = {**IN_KERNELS, "no_cpython_wrapper": False, "forceinline": False}
    compiled = numba.njit(**options)(_elastic_stresses.py_func)  # of kept code there is no text
    compiled(HYPERELASTIC["ogden"].law(), True, np.ones(COLUMNS * COLUMN))
    (code,) = compiled.inspect_llvm().values()
    assert re.search(r"call .*@llvm\.sqrt\.v\d+f64", code)
