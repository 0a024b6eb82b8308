"""The internal forces of a time step: their work is the change of the strain energy, they have no torque about the middle of
the step, and for a step without motion they are those of the state."""

import numpy as np
import pytest
from materials.samples import HYPERELASTIC, USERS
from solids import EDGE, block_of

from pellucid.approximants.nodal import NODAL_APPROXIMANTS
from pellucid.bodies.meshless_solid.step_forces import in_rows
from pellucid.case import Case
from pellucid.simulation.simulation import Simulation

DT = 0.01
ELASTIC = {"kind": "decoupled-neo-hookean", "young_modulus": 3e3, "poisson_ratio": 0.45}
VISCOUS = {
    "kelvin-voigt": {"kind": "kelvin-voigt", "density": 1e3, "elastic": ELASTIC, "viscosity": 5.0},
    "prony": {"kind": "prony", "density": 1e3, "elastic": ELASTIC, "branches": [{"share": 0.5, "relaxation_time": 0.05}]},
}


def rotated(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def step_of(size=0.1, angle=1.0, **settings):
    """A block of 2 × 2 × 2 cells, its step forces, and random displacements at the start and at the end of a step, with strains
    of `size` and a rotation between them."""
    table = {"schema": 1, "title": "a test", "time": {"end": 1.0}, "body": [block_of(cells=(2, 2, 2)) | settings]}
    body = Simulation(Case.model_validate(table), threads=1).bodies[0]
    rng, x = np.random.default_rng(3), body.mesh.nodes
    strains = (np.eye(3) + size * rng.uniform(-0.5, 0.5, (3, 3)) for _ in range(2))
    noise = 0.2 * size * EDGE
    start, end = (x @ strain + noise * rng.uniform(-1.0, 1.0, x.shape) for strain in strains)
    return body, body._forces.in_step(), start - x, end @ rotated(angle).T - x


def stored(body, displacement):
    force = np.empty_like(displacement)
    body._forces.find(displacement, force, 0.0)
    return body._forces.stored(), force


def in_step(body, forces, start, end):
    """Return the energies at the start and at the end of a step, and the forces in it."""
    after, _ = stored(body, end)
    before, _ = stored(body, start)
    forces.begin(DT)
    force = np.empty_like(start)
    assert forces.find(end, force)
    return before, after, force


@pytest.mark.parametrize("name", sorted(HYPERELASTIC.keys() - USERS.keys()))
@pytest.mark.parametrize("averaged", [False, True])
def test_the_work_is_the_change_of_the_strain_energy(name, averaged):
    """The error is of fifth order in the change of the strains, and of third relative to the energy. Where fibres begin to
    carry, here at rest, the stiffness jumps: then it is as small, but a constant share of the energy."""
    material, order = HYPERELASTIC[name].model_dump(mode="json"), 0.0 if name == "holzapfel-gasser-ogden" else 2.7
    errors = []
    for size in (0.04, 0.02):
        body, forces, start, end = step_of(size, material=material, volume_averaging=averaged)
        before, after, force = in_step(body, forces, start, end)
        errors.append(abs(np.sum(force * (end - start)) + after - before) / max(before, after))
    assert errors[0] < 2e-4
    assert errors[1] < errors[0] / 2.0**order


@pytest.mark.parametrize("approximant", NODAL_APPROXIMANTS.entries)
def test_there_is_no_force_and_no_torque_in_sum(approximant):
    body, forces, start, end = step_of(approximant={"kind": approximant})
    _, _, force = in_step(body, forces, start, end)
    middle = body.mesh.nodes + 0.5 * (start + end)
    size = np.abs(force).sum()
    assert np.abs(force.sum(axis=0)).max() < 1e-14 * size
    assert np.abs(np.cross(middle, force).sum(axis=0)).max() < 1e-14 * size * EDGE


@pytest.mark.parametrize("averaged", [False, True])
def test_a_step_without_motion_has_the_forces_of_the_state(averaged):
    body, forces, start, _ = step_of(volume_averaging=averaged, initial_stress=[200.0, 0.0, -100.0, 0.0, 30.0, 0.0])
    _, _, force = in_step(body, forces, start, start)
    _, of_state = stored(body, start)
    assert np.abs(force - of_state).max() < 1e-13 * np.abs(of_state).max()


@pytest.mark.parametrize("angle", [0.1, 2.0])
def test_a_rotation_strains_nothing(angle):
    """Although the mean of both deformation gradients is no rotation."""
    body, forces, _, _ = step_of()
    x = body.mesh.nodes
    before, after, force = in_step(body, forces, np.zeros_like(x), x @ rotated(angle).T - x)
    assert np.abs(force).max() < 1e-12 * 3e3 * EDGE**2
    assert max(before, after) < 1e-12 * 3e3 * EDGE**3


def test_an_inverted_end_is_found():
    """Energies depend on FᵀF, which does not change if the body is mirrored."""
    body, forces, _, _ = step_of()
    x = body.mesh.nodes
    stored(body, np.zeros_like(x))
    forces.begin(DT)
    assert not forces.find(-2.0 * x * [1.0, 0.0, 0.0], np.empty_like(x))


def end_of(body, forces, displacement):
    """Advance the states of the points to the end of a step; return the Cauchy stresses of the points and the heat so far."""
    force = np.empty_like(displacement)
    body._forces.find(displacement, force, 0.0)
    forces.advance_states(displacement, in_rows(body._forces.solid.deformation))
    body._forces.find(displacement, force, 0.0)
    n = 4 * len(body.mesh.cells)
    return body._forces.arrays["stress"][:n].copy(), body._forces.lost


@pytest.mark.parametrize("material", VISCOUS.values(), ids=VISCOUS)
def test_viscous_stresses_turn_with_the_body(material):
    """A step with a rotation has the forces and stresses of the same step without, but turned, and the same heat. A step of a
    rotation alone has no heat."""
    found = []
    for angle in (0.0, 1.5):
        body, forces, start, end = step_of(0.05, angle, material=material)
        x = body.mesh.nodes
        in_step(body, forces, np.zeros_like(x), start)
        end_of(body, forces, start)
        _, _, force = in_step(body, forces, start, end)
        stress, lost = end_of(body, forces, end)
        assert np.abs(np.cross(x + 0.5 * (start + end), force).sum(axis=0)).max() < 1e-13 * np.abs(force).sum() * EDGE
        in_step(body, forces, end, (x + end) @ rotated(0.7).T - x)
        _, after = end_of(body, forces, (x + end) @ rotated(0.7).T - x)
        found.append((stress, lost, after))
    for column in (2, slice(0, 2)):
        plane = found[0][0][:, column], found[1][0][:, column]
        invariant = [part if column == 2 else part.sum(axis=1) for part in plane]
        assert np.abs(invariant[1] - invariant[0]).max() < 1e-9 * np.abs(invariant[0]).max(), "about z"
    assert found[1][1] == pytest.approx(found[0][1], rel=1e-9)
    for _, lost, after in found:
        assert lost > 0.0
        if material["kind"] == "kelvin-voigt":
            assert after == pytest.approx(lost, rel=1e-9)
