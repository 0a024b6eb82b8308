"""Internal forces of a meshless solid: the derivative of its energy, rigid motions, uniform strain, threads."""

import numpy as np
import pytest
from algebra import rotation
from meshes import irregular

from pellucid.approximants.nodal import NODAL_APPROXIMANTS
from pellucid.approximants.nodal.consistency import boundary_integrals
from pellucid.bodies.meshless_solid.forces import in_kernels, internal_forces
from pellucid.bodies.meshless_solid.functions import make_tables
from pellucid.bodies.meshless_solid.solid import CHUNK, ENERGY, LEAST_J
from pellucid.geometry.meshes.points import spatial_order
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.jit import set_threads
from pellucid.materials.elastic import lame
from pellucid.materials.law import energy, first_piola_kirchhoff
from pellucid.materials.neo_hookean import NeoHookean

LAW = NeoHookean(*lame(3000.0, 0.45), 1000.0)
FORMS = [(points, averaged) for points in (1, 4, 8) for averaged in (False, True)]


class Solid:
    """Tables with their forces, of the unit cube of a mesh of tetrahedra."""

    def __init__(self, n=3, kind="cell-based-maximum-entropy", points=4, consistent=True, averaged=False, storage=np.float32):
        mesh = irregular(n, 3)
        order = spatial_order(mesh.nodes[mesh.cells].mean(axis=1))
        self.mesh = SimplexMesh(mesh.nodes, mesh.cells[order])
        approximant = NODAL_APPROXIMANTS.entries[kind]()
        self.solid, self.node_volume, _ = make_tables(
            self.mesh, approximant.evaluator(self.mesh), LAW, points, consistent, averaged, storage
        )
        self.bundle, self.averaged = in_kernels(self.solid), averaged

    def forces(self, displacement):
        force = np.zeros_like(self.mesh.nodes)
        self.solid.displacement[:] = displacement
        internal_forces(len(self.solid.sums), (len(force) + CHUNK - 1) // CHUNK, self.bundle, 0.0, False, force)
        return force

    def energy(self, displacement):
        self.forces(displacement)
        return self.solid.sums[:, ENERGY].sum() + (self.solid.node_sums[:, ENERGY].sum() if self.averaged else 0.0)


def at_random(mesh, size, seed=3):
    return np.random.default_rng(seed).uniform(-size, size, mesh.nodes.shape)


@pytest.mark.parametrize(("points", "averaged"), FORMS)
def test_forces_are_the_derivative_of_the_energy(points, averaged):
    body = Solid(points=points, averaged=averaged)
    u, along = at_random(body.mesh, 0.02), at_random(body.mesh, 1.0, seed=4)
    step = 1e-6  # central differences of a smooth energy: an error of step² and of rounding over step
    work = (body.energy(u + step * along) - body.energy(u - step * along)) / (2.0 * step)
    assert -np.sum(body.forces(u) * along) == pytest.approx(work, rel=1e-7)


@pytest.mark.parametrize(("points", "averaged"), FORMS)
def test_a_rigid_motion_takes_no_force(points, averaged):
    body = Solid(points=points, averaged=averaged)
    Q = rotation(1)
    force = body.forces(body.mesh.nodes @ (Q - np.eye(3)).T + (1.0, -2.0, 3.0))
    assert force == pytest.approx(0.0, abs=1e-9 * 3000.0)
    assert body.solid.sums[:, LEAST_J].min() == pytest.approx(1.0, abs=1e-11)


@pytest.mark.parametrize(("points", "averaged"), FORMS)
@pytest.mark.parametrize(("storage", "within"), [(np.float64, 1e-10), (np.float32, 1e-8)])  # singles round gradients by 6e-8
def test_a_uniform_strain_passes_the_patch_test(points, averaged, storage, within):
    """Of a linear displacement: the energy of the volume, no force on nodes within, on those of the faces -∮ p_a P n dS."""
    body = Solid(points=points, averaged=averaged, storage=storage)
    F = np.eye(3) + np.array([[0.1, 0.05, 0.0], [0.0, -0.2, 0.1], [0.05, 0.0, 0.15]])
    u = body.mesh.nodes @ (F - np.eye(3)).T
    law_F = tuple(F.ravel().tolist())
    assert body.energy(u) == pytest.approx(energy(LAW, law_F), rel=1e-11)
    force, P = body.forces(u), np.array(first_piola_kirchhoff(LAW, law_F)).reshape(3, 3)
    exact = (
        -boundary_integrals(body.mesh, NODAL_APPROXIMANTS.entries["cell-based-maximum-entropy"]().evaluator(body.mesh)) @ P.T
    )
    assert force == pytest.approx(exact, abs=within * abs(P).max())


@pytest.mark.parametrize(("points", "averaged"), FORMS)
def test_forces_and_torques_add_up_to_nothing(points, averaged):
    """Whatever the precision of the gradients: only sums in doubles round."""
    body = Solid(points=points, averaged=averaged)
    u = at_random(body.mesh, 0.03)
    force, scale = body.forces(u), abs(body.forces(u)).sum()
    assert force.sum(axis=0) == pytest.approx(0.0, abs=1e-14 * scale)
    assert np.cross(body.mesh.nodes + u, force).sum(axis=0) == pytest.approx(0.0, abs=1e-13 * scale)


@pytest.mark.parametrize(("points", "averaged"), FORMS)
def test_gradients_in_single_precision_give_the_forces_of_doubles(points, averaged):
    single, double = (Solid(points=points, averaged=averaged, storage=storage) for storage in (np.float32, np.float64))
    u = at_random(single.mesh, 0.03)
    assert single.solid.gradients.numbers.dtype == np.float32
    expected = double.forces(u)
    # a gradient is rounded by 2⁻²⁴ of the largest of its point or so; a force is a sum of hundreds of them
    assert single.forces(u) == pytest.approx(expected, abs=3e-7 * abs(expected).max())
    assert single.energy(u) == pytest.approx(double.energy(u), rel=1e-7)


def test_without_consistent_gradients_the_patch_test_fails():
    body = Solid(consistent=False)
    within = ((body.mesh.nodes > 0.0) & (body.mesh.nodes < 1.0)).all(axis=1)
    force = body.forces(body.mesh.nodes * (0.0, 0.0, 0.1))
    assert abs(force[within]).max() > 1e-3 * abs(force).max()


def test_the_masses_add_up():
    assert Solid(points=1).node_volume.sum() == pytest.approx(1.0, rel=1e-13)


def test_the_same_bits_on_any_number_of_threads():
    body = Solid(n=6, consistent=False, averaged=True)  # several blocks
    assert len(body.solid.sums) > 1
    u, found = at_random(body.mesh, 0.01), []
    for threads in (1, 2, 4):
        set_threads(threads)
        found.append(body.forces(u).tobytes())
    assert found[0] == found[1] == found[2]
