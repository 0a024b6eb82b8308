"""Membranes of finite elements: patches, rigid motions, momentum, pressure, hourglass modes, energy."""

import numpy as np
import pytest
from elements import (
    DENSITY,
    body_of,
    bring,
    distorted,
    element_sheet,
    forces,
    global_stress,
    places,
    rim,
    rotation,
    step,
    supported,
    wall,
)
from membranes import NU, THICKNESS, E, neo_hookean_stretch
from small_cases import advance

from pellucid.case import Case
from pellucid.energy import CONTACT, FIRST_LOAD, GRAVITY, INTERNAL, MOTION, SUPPORT
from pellucid.errors import RunStopped
from pellucid.geometry.surfaces.surface import Surface
from pellucid.jit import set_threads
from pellucid.simulation.simulation import Simulation

every_law = pytest.mark.parametrize("law", ["linear-membrane", "neo-hookean-membrane"])
every_mesh = pytest.mark.parametrize("elements", ["quads", "triangles"])
SHEET = {"rectangle": {"corner": (-0.49, -0.48, 0.03), "first_edge": (1, 0, 0), "second_edge": (0, 1, 0), "points": (7, 7)}}


def distorted_body(elements="quads", law="linear-membrane", amount=0.05, across=0.0, **more):
    """A sheet whose elements are anything but squares."""
    mesh = distorted(Surface.model_validate(SHEET).mesh(elements), amount, across=across)
    return body_of(element_sheet(law, **more), mesh), mesh


def stretched_by(body, gradient, steps=20):
    """Bring the nodes to (I + gradient) x in equal parts."""
    start = places(body)
    for k in range(1, steps + 1):
        bring(body, start @ (np.eye(3) + k / steps * np.array(gradient)).T)


@every_law
@every_mesh
def test_an_affine_motion_of_distorted_elements_leaves_uniform_stress_and_inner_nodes_in_balance(elements, law):
    body, mesh = distorted_body(elements, law)
    stretched_by(body, [[0.02, 0.01, 0.0], [-0.004, -0.005, 0.0], [0.0, 0.0, 0.0]])
    stress = global_stress(body)
    scale = np.abs(stress).max()
    # every element meets the same history of gradients, whatever its shape
    assert np.ptp(stress, axis=0).max() < 1e-11 * scale
    force = np.linalg.norm(forces(body), axis=1)
    assert force[~rim(mesh)].max() < 1e-11 * force.max()
    if elements == "quads":
        assert np.abs(body.element_arrays["hourglass"]).max() < 1e-11 * force.max()
        assert np.abs(body.element_arrays["hourglass_energy"]).max() < 1e-20 * body.totals.stored


@every_law
@every_mesh
@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 2, -0.5)])
def test_a_quarter_turn_in_two_steps_takes_the_stress_along_and_nothing_else(axis, elements, law):
    body, _ = distorted_body(elements, law, across=0.02)
    stretched_by(body, [[0.02, 0.01, 0.0], [0.0, -0.005, 0.0], [0.0, 0.0, 0.0]])
    before, energy = global_stress(body), body.totals.stored
    kept = {name: array.copy() for name, array in body.element_arrays.items()}
    start = places(body)
    for half in (1, 2):
        bring(body, start @ rotation(axis, half * np.pi / 4).T)
    Q = rotation(axis, np.pi / 2)
    assert np.abs(global_stress(body) - Q @ before @ Q.T).max() < 1e-12 * np.abs(before).max()
    assert body.totals.stored == pytest.approx(energy, rel=1e-12)
    of_quads = ("shape", "hourglass", "turn") if elements == "quads" else ()
    for name in ("plane_stress", "thickness", "volume", *of_quads):
        scale = max(np.abs(kept[name]).max(), 1e-9 * E * THICKNESS if name == "hourglass" else 0.0)
        assert np.abs(body.element_arrays[name] - kept[name]).max() < 1e-12 * scale, name


@every_mesh
def test_forces_have_no_resultant_and_no_moment(elements):
    """Warped, sheared, with hourglass forces: what elements do to their nodes is in balance."""
    body, _ = distorted_body(elements, across=0.02)
    generator = np.random.default_rng(1)
    start = places(body)
    for _ in range(5):
        bring(body, start + generator.uniform(-0.01, 0.01, start.shape))
    force = forces(body)
    scale = np.linalg.norm(force, axis=1).sum()
    assert np.abs(force.sum(axis=0)).max() < 1e-14 * scale
    assert np.abs(np.cross(places(body), force).sum(axis=0)).max() < 1e-14 * scale
    assert elements == "triangles" or np.abs(body.element_arrays["hourglass"]).max() > 0.0


@every_mesh
def test_a_linear_membrane_pulled_along_one_axis_or_two(elements):
    """ε' is the integral of the stretching: the logarithm of the stretch, to (step)²/12; the thickness goes with it."""
    for gradient in (np.diag([0.1, 0.0, 0.0]), np.diag([0.1, 0.1, 0.0]), np.diag([0.1, -0.05, 0.0])):
        body, _ = distorted_body(elements)
        steps = 50
        stretched_by(body, gradient, steps)
        e1, e2 = np.log1p(np.diag(gradient)[:2])
        C = E / (1.0 - NU**2)
        frame = body.frame()
        assert frame["stress"][:, 0] == pytest.approx(C * (e1 + NU * e2), abs=1e-6 * C)
        assert frame["stress"][:, 1] == pytest.approx(C * (e2 + NU * e1), abs=1e-6 * C)
        assert np.abs(frame["stress"][:, 2:]).max() < 1e-12 * C
        assert frame["thickness"] == pytest.approx(THICKNESS * (1.0 - NU / (1.0 - NU) * (e1 + e2)), rel=1e-6)
        volume = body.element_arrays["volume"].sum()
        assert volume == pytest.approx((1.0 + gradient[0, 0]) * (1.0 + gradient[1, 1]) * frame["thickness"][0], rel=1e-12)


@every_mesh
@pytest.mark.parametrize("stretches", [(1.5, 1.0), (1.3, 1.3), (1.2, 0.9)])
def test_a_neo_hookean_membrane_keeps_the_exact_stretch_in_any_number_of_steps(stretches, elements):
    """Against the three-dimensional law at the thickness stretch that leaves no stress across, found by bisection."""
    body, _ = distorted_body(elements, "neo-hookean-membrane")
    stretched_by(body, np.diag([stretches[0] - 1.0, stretches[1] - 1.0, 0.0]), 3)
    in_plane, third = neo_hookean_stretch(stretches)
    frame = body.frame()
    for component, expected in enumerate(in_plane):
        assert frame["stress"][:, component] == pytest.approx(expected, rel=1e-10, abs=1e-10 * E)
    assert frame["thickness"] == pytest.approx(THICKNESS * third, rel=1e-12)
    assert frame["density"] == pytest.approx(DENSITY / (np.prod(stretches) * third), rel=1e-12)


def test_simple_shear_of_a_neo_hookean_membrane_is_second_order_in_the_step():
    """The bisector of sheared tangents does not turn with the material; what is carried does: σ₁₂ = μ γ."""
    errors = []
    mu = E / (2.0 * (1.0 + NU))
    for steps in (10, 20):
        body, _ = distorted_body("quads", "neo-hookean-membrane")
        stretched_by(body, [[0.0, 0.5, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]], steps)
        errors.append(abs(body.frame()["stress"][:, 5].mean() - mu * 0.5) / (mu * 0.5))
    assert errors[1] < 1e-3
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.2)


def hourglass_pattern(body, amplitude, axis):
    """Velocities or shifts that alternate from node to node of a grid of 7 × 7."""
    i, j = np.divmod(np.arange(49), 7)
    pattern = np.zeros((49, 3))
    pattern[:, axis] = amplitude * (-1.0) ** (i + j)
    return pattern


@pytest.mark.parametrize("kind", ["stiffness", "viscous"])
def test_hourglass_modes_in_the_plane_are_resisted_and_their_energy_is_counted(kind):
    body = body_of(element_sheet(hourglass={"kind": kind, "coefficient": 0.1}))
    pattern = hourglass_pattern(body, 1e-3, 0)
    body.arrays["velocity"][:] = pattern
    body.renew_totals()
    energy, dt = body.totals.kinetic, 0.5 / body.totals.rate
    least, most = energy, 0.0
    for _ in range(40):
        step(body, dt)
        least, most = min(least, body.totals.kinetic), max(most, body.totals.parts["hourglass"])
    # nodes on the rim have half the mass and half the elements: the pattern is a mode of the sheet. Springs bring it to rest
    # within half a step, a ninth of a radian; dashpots leave 0.95 of the velocity in each step
    assert least < 0.02 * energy
    assert most == pytest.approx(energy, rel=0.1)
    assert body.totals.stored == body.totals.parts["hourglass"] + body.element_arrays["strain_energy"].sum()
    assert np.abs(body.element_arrays["strain_energy"]).max() < 1e-10 * energy


def test_without_control_nothing_resists_an_hourglass_mode():
    body = body_of(element_sheet(hourglass={"coefficient": 0.0}))
    body.arrays["velocity"][:] = hourglass_pattern(body, 1e-3, 0)
    body.renew_totals()
    energy = body.totals.kinetic
    for _ in range(20):
        step(body, 0.5 / body.totals.rate)
    assert body.totals.kinetic == pytest.approx(energy, rel=1e-6)


def test_the_stiffness_of_full_integration():
    """A square with u = q ξη has the energy ½ q² (4/3) E/(1-ν²) (1 + (1-ν)/2) t: the control has it at κ = (3-ν)/6."""
    body = body_of(element_sheet(points=(2, 2), hourglass={"coefficient": (3.0 - NU) / 6.0}), counts=(4, 4, 4), cell=1.0)
    q = 1e-6
    bring(body, places(body) + q * np.array([[1.0, 0, 0], [-1.0, 0, 0], [-1.0, 0, 0], [1.0, 0, 0]]))
    exact = 0.5 * q**2 * 4.0 / 3.0 * E / (1.0 - NU**2) * (1.5 - 0.5 * NU) * THICKNESS
    assert body.totals.parts["hourglass"] == pytest.approx(exact, rel=1e-5)


def test_warping_of_a_sheet_under_tension_is_resisted_as_by_full_integration():
    """Of w = q ξη on a square under σ₁₁ = σ₂₂ = σ: ½ ∫ σ t |∇w|² dA = ½ q² (8/3) σ t."""
    body = body_of(element_sheet("neo-hookean-membrane", points=(2, 2)), counts=(4, 4, 4), cell=1.0)
    stretched_by(body, np.diag([0.05, 0.05, 0.0]))
    sigma, thickness, q = body.frame()["stress"][0, 0], body.frame()["thickness"][0], 1e-3
    up = np.array([[0, 0, 1.0], [0, 0, -1.0], [0, 0, -1.0], [0, 0, 1.0]])
    before = body.totals.stored
    bring(body, places(body) + q * up)
    # the tension grows by the square of the warping itself, q²/3 of strain
    assert body.totals.stored - before == pytest.approx(0.5 * q**2 * 8.0 / 3.0 * sigma * thickness, rel=1e-4)
    along = (forces(body) * up).sum()
    assert along == pytest.approx(-8.0 / 3.0 * sigma * thickness * q, rel=1e-4)


@pytest.mark.parametrize("surface", [{"icosphere": {"centre": (0, 0, 0), "radius": 0.5, "refinements": 2}},
                                     {"sphere": {"centre": (0, 0, 0), "radius": 0.5, "divisions": 4}}])  # fmt: skip
def test_pressure_on_a_closed_surface_has_no_resultant_and_does_the_work_of_its_volume(surface):
    body = body_of(element_sheet(surface=surface))
    generator = np.random.default_rng(2)
    force = np.zeros((body.n_points, 3))
    body.surface.add_pressure_forces(body.arrays["position"], 3.0, force)
    scale = np.linalg.norm(force, axis=1).sum()
    assert np.abs(force.sum(axis=0)).max() < 1e-14 * scale
    x = places(body)
    assert np.abs(np.cross(x, force).sum(axis=0)).max() < 1e-14 * scale
    assert np.einsum("ij,ij->", x, force) == pytest.approx(3.0 * 3.0 * volume_of(body, x), rel=1e-12)
    shift = generator.uniform(-1e-4, 1e-4, x.shape)
    growth = volume_of(body, x + shift) - volume_of(body, x - shift)
    assert 2.0 * np.einsum("ij,ij->", shift, force) == pytest.approx(3.0 * growth, rel=1e-6)


def volume_of(body, x):
    """Volume within a closed mesh; within bilinear quadrilaterals, the mean of both ways to cut them in two."""
    triangles, quads = body.cells().triangles, body.cells().quadrilaterals
    cuts = [triangles] if len(triangles) else []
    volume = sum(np.linalg.det(x[cut]).sum() / 6.0 for cut in cuts)
    if len(quads):
        ways = [(0, 1, 2), (0, 2, 3), (0, 1, 3), (1, 2, 3)]
        volume += 0.5 * sum(np.linalg.det(x[quads[:, way]]).sum() / 6.0 for way in ways)
    return volume


@every_law
@every_mesh
def test_a_free_sheet_keeps_energy_and_momentum(elements, law):
    """Stretched and let go, in space: kinetic and stored energy change into each other, with nothing lost."""
    body, _ = distorted_body(elements, law)
    stretched_by(body, [[0.02, 0.01, 0.0], [0.0, -0.005, 0.0], [0.0, 0.0, 0.0]])
    body.arrays["velocity"][:] = (0.01, -0.02, 0.005)
    body.renew_totals()
    momentum, dt = body.totals.momentum, 0.2 / body.totals.rate
    worst, internal, stored = 0.0, 0.0, body.totals.stored
    for _ in range(400):
        step(body, dt)
        internal += body.work().works[INTERNAL]
        # the works and energies of a step lie half a step apart, which is a share of what moves in a step and does not grow
        worst = max(worst, abs(internal + body.totals.stored - stored) / stored)
    assert np.abs(body.totals.momentum - momentum).max() < 1e-13 * np.abs(momentum).max()
    assert worst < 0.05
    assert body.totals.kinetic - 0.5 * body.mass * 5.25e-4 == pytest.approx(internal, rel=1e-9)


def test_an_element_that_turns_over_stops_the_run_by_the_name_of_its_first_node():
    body = body_of(element_sheet())
    target = places(body)
    target[8] += (0.6, 0.0, 0.0)
    with pytest.raises(RunStopped, match="element at this node turned over"):
        bring(body, target)


def test_a_node_that_leaves_the_grid_stops_the_run():
    body = body_of(element_sheet())
    with pytest.raises(RunStopped, match="left the grid"):
        bring(body, places(body) + np.array((0.0, 0.0, 2.5)))


def test_prescribed_directions_take_what_holds_them():
    """Half the rim pulled, the other half held: reactions are the impulses that the free nodes miss, their work is counted."""
    body = body_of(element_sheet())
    left, right = places(body)[:, 0] < -0.4, places(body)[:, 0] > 0.4
    body.add_supports([supported(left, "xyz"), supported(right, "x", (0.1, 7.0, 7.0))])
    dt, total, given, internal = 0.5 / body.totals.rate, np.zeros(3), 0.0, 0.0
    for _ in range(50):
        step(body, dt)
        done = body.work()
        total += done.reactions.sum(axis=0)
        given += done.works[SUPPORT]
        internal += done.works[INTERNAL]
    v = body.arrays["velocity"]
    assert np.all(v[left] == 0.0)
    assert np.all(v[right, 0] == 0.1)
    assert np.abs(v[right, 1]).max() < 0.1
    assert body.totals.momentum == pytest.approx(total, abs=1e-12 * np.abs(total).max())
    assert body.totals.kinetic == pytest.approx(given + internal, rel=1e-12)


def test_prescribed_motions_do_what_supports_of_their_velocity_do_and_it_is_counted_as_theirs():
    """The same bits of velocities; works along the mean velocity and impulses go to the motions, and the axes alone that a
    motion prescribes are led."""
    ends = []
    for moved in (False, True):
        body = body_of(element_sheet())
        left, right = places(body)[:, 0] < -0.4, places(body)[:, 0] > 0.4
        if moved:
            body.add_supports([supported(left, "xyz")])
            body.add_motions(["pull", "rest"], right.astype(np.int64), np.array([(1, 0, 0), (1, 1, 1)]))
        else:
            body.add_supports([supported(left, "xyz"), supported(right, "x", (0.1, 0.0, 0.0))])
        works, given, taken = np.zeros(FIRST_LOAD + 1), np.zeros(3), np.zeros(3)
        for _ in range(50):
            if moved:
                body.set_motion_velocities(np.array([(0.1, 7.0, 7.0), (9.0, 9.0, 9.0)]))
            step(body, 1e-3)
            done = body.work()
            works += done.works
            given += done.motions["pull"] if moved else done.reactions[1]
            taken += done.reactions[0]
            assert list(done.motions) == (["pull", "rest"] if moved else [])
            assert not moved or not done.motions["rest"].any()
        ends.append((body.arrays["velocity"].tobytes(), works, given, taken, body.totals))
    (held_velocity, held_works, held_given, held_taken, _), (velocity, works, given, taken, totals) = ends
    assert velocity == held_velocity
    assert given.tolist() == held_given.tolist()
    assert taken.tolist() == held_taken.tolist()
    assert held_works[MOTION] == 0.0 < works[MOTION]
    jerk = 0.5 * body.arrays["mass"][right].sum() * 0.1**2  # in the first step the mean is half the prescribed velocity
    assert works[MOTION] == pytest.approx(0.1 * given[0] - jerk, rel=1e-12)
    assert works[SUPPORT] + works[MOTION] == pytest.approx(held_works[SUPPORT], rel=1e-12)
    assert works[INTERNAL] == held_works[INTERNAL]
    assert totals.kinetic == pytest.approx(works[INTERNAL] + works[SUPPORT] + works[MOTION], rel=1e-12)
    assert totals.momentum == pytest.approx(given + taken, abs=1e-12 * np.abs(given).max())


def test_no_node_passes_a_wall():
    """A sheet in a box of 4 m flies into its lower x and upper y faces: what stops it there is work of supports."""
    body = body_of(element_sheet())
    body.add_supports([wall(body, 0, 0), wall(body, 1, 1)])
    body.arrays["velocity"][:] = (-4.0, 2.0, 0.5)
    body.renew_totals()
    momentum, energy, dt = body.totals.momentum, body.totals.kinetic, 0.5 / body.totals.rate
    taken, given, internal = np.zeros((3, 3)), 0.0, 0.0
    for _ in range(round(0.9 / dt)):
        step(body, dt)
        done = body.work()
        taken += done.reactions
        given += done.works[SUPPORT]
        internal += done.works[INTERNAL]
    x = places(body)
    assert x[:, 0].min() >= -2.0
    assert x[:, 1].max() <= 2.0
    # it would be 2 m beyond the one and 0.3 m beyond the other
    assert taken[0, 0] > 4.0 * body.mass
    assert taken[1, 1] < 0.0
    assert not taken[0, 1:].any()
    assert body.totals.momentum - momentum == pytest.approx(taken.sum(axis=0), abs=1e-12 * np.abs(momentum).max())
    assert body.totals.kinetic - energy == pytest.approx(given + internal, rel=1e-10)


def test_gravity_and_contact_act_on_the_nodes():
    body = body_of(element_sheet(), gravity=(0.0, 0.0, -10.0))
    body.grid.nodes.velocity_increment[:], body.velocity_field.pressed = (0.01, 0.0, 0.02), True
    body.begin(1e-3)
    body.predict(1e-3)
    body.correct(remap=True)
    done = body.work()
    assert body.arrays["velocity"] == pytest.approx(np.tile((0.01, 0.0, 0.01), (49, 1)), abs=1e-15)
    m = body.mass
    assert m == pytest.approx(DENSITY * THICKNESS)
    assert done.works[GRAVITY] == pytest.approx(-0.5 * m * 1e-4, rel=1e-12)
    assert body.totals.kinetic == pytest.approx(done.works[GRAVITY] + done.works[CONTACT], rel=1e-12)
    # momentum twice on the grid: what came before the step was zero
    assert body.grid.nodes.momentum.sum(axis=0) == pytest.approx(body.totals.momentum)
    assert body.grid.nodes.mass.sum() == pytest.approx(m)


def test_forces_arrive_on_the_grid():
    """Of stress, which have no resultant, of a pressure, and gravity."""
    mesh = distorted(Surface.model_validate(SHEET).mesh("quads"), 0.05)
    body = body_of(element_sheet(), mesh, gravity=(0.0, -10.0, 0.0))
    stretched_by(body, np.diag([0.02, 0.0, 0.0]))
    body.begin(1e-3)
    body.add_pressure(5.0, FIRST_LOAD)
    body.predict(1e-3)
    force = body.grid.nodes.force.sum(axis=0)
    area = 1.02
    assert force == pytest.approx((0.0, -10.0 * body.mass, 5.0 * area), abs=1e-9)
    assert np.abs(body.grid.nodes.force[:, :2]).max() > 10.0


def test_the_step_that_the_body_asks_for_is_stable_and_not_much_too_small():
    """Noise in the plane of a square grows above the largest stable step, sqrt(2/(1+ν)) = 1.24 times what the bound says."""
    for factor, stable in ((1.0, True), (1.2, True), (1.28, False)):
        body = body_of(element_sheet(points=(2, 2)), counts=(4, 4, 4), cell=1.0)
        generator = np.random.default_rng(3)
        body.arrays["velocity"][:, :2] = generator.uniform(-1e-6, 1e-6, (4, 2))
        body.renew_totals()
        energy, dt = body.totals.kinetic, factor / body.totals.rate
        with np.errstate(all="ignore"):
            for _ in range(200):
                try:
                    step(body, dt)
                except RunStopped:
                    break
        assert (body.totals.kinetic < 10.0 * energy) == stable


@every_mesh
def test_a_string_of_elements_vibrates_as_the_book_says_to_second_order(elements):
    """A stretched strip, held at both ends, plucked: half a period is L sqrt(ρ/σ) for small waves."""
    errors = []
    for cells in (8, 16):
        edges = {"first_edge": (1, 0, 0), "second_edge": (0, 1 / cells, 0), "corner": (-0.5, 0, 0), "points": (cells + 1, 2)}
        body = body_of(element_sheet(elements=elements, surface={"rectangle": edges}))
        stretched_by(body, np.diag([0.02, -NU * 0.02, 0.0]))
        x = places(body)
        ends = np.abs(x[:, 0]) > 0.509
        body.add_supports([supported(np.ones(len(x), bool), "xy"), supported(ends, "z")])
        start = np.zeros_like(x)
        start[:, 2] = 1e-3 * np.cos(np.pi * x[:, 0] / 1.02)
        start[ends] = 0.0
        body.arrays["velocity"][:] = start
        body.renew_totals()
        density = body.mass / body.element_arrays["volume"].sum()
        exact = 1.02 * np.sqrt(density / body.frame()["stress"][:, 0].mean())
        dt, time, previous, middle = 0.25 / body.totals.rate, 0.0, 0.0, np.argmin(np.linalg.norm(x, axis=1))
        time = 0.5 * dt  # the velocities at the start are those of half a step later
        while True:
            step(body, dt)
            time += dt
            now = places(body)[middle, 2] - x[middle, 2]
            if previous > 0.0 >= now:
                break
            previous = now
        errors.append(abs(time - dt * now / (now - previous) - 0.5 * dt - exact) / exact)
    assert errors[1] < 2e-3
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.3)


def test_the_same_bits_on_any_number_of_threads_and_from_a_copy_of_the_arrays():
    """More chunks than one, nodes that come to other cells on the way."""
    ends = []
    for threads in (1, 2, 2):
        set_threads(threads)
        body = body_of(element_sheet(points=(41, 41)), cell=0.05, counts=(40, 40, 8), lower=(-0.9, -0.9, -0.2))
        body.arrays["velocity"][:] = np.sin(5.0 * body.arrays["position"][:, [1, 2, 0]])
        body.renew_totals()
        for k in range(60):
            step(body, 0.5 / body.totals.rate, pressure=100.0)
            if k == 30 and len(ends) == 2:
                body = copied(body)
        ends.append([body.arrays["position"].tobytes(), body.totals.stored, body.work().works.tobytes()])
    set_threads(1)
    assert ends[0] == ends[1] == ends[2]


def copied(body):
    """Another body that takes up the arrays of this one, as from a checkpoint."""
    other = body_of(element_sheet(points=(41, 41)), cell=0.05, counts=(40, 40, 8), lower=(-0.9, -0.9, -0.2))
    other.restore({name: array.copy() for name, array in body.state_arrays().items()})
    other.totals.restore(body.totals.to_data())
    return other


def test_alone_it_moves_by_the_same_bits_without_a_grid():
    """A sheet held at one edge, under gravity and a pressure; a restart keeps the bits too."""
    conditions = {
        "support": [{"name": "edge", "where": {"box": {"lower": (-0.6, -0.6, -1), "upper": (-0.45, 0.6, 1)}}}],
        "pressure": [{"body": "sheet", "value": 3.0}],
        "motion": [
            {
                "name": "pull",
                "body": "sheet",
                "part": {"box": {"lower": (0.45, -0.6, -1), "upper": (0.6, 0.6, 1)}},
                "displacement": {"x": {"kind": "steady", "velocity": 0.1}},
            }
        ],
        "gravity": (0.0, 0.0, -9.81),
    }
    table = {"schema": 1, "title": "a sheet", "time": {"end": 1.0, "step": 1e-4}, "body": [element_sheet()]} | conditions
    grid = {"grid": {"lower": (-2, -2, -2), "upper": (2, 2, 2), "cell": 0.25}}
    free, beside = (Simulation(Case.model_validate(table | more), threads=1) for more in ({}, grid))
    for sim in (free, beside):
        advance(sim, 40)
    for name in ("position", "velocity"):
        assert np.array_equal(free.bodies[0].arrays[name], beside.bodies[0].arrays[name])
    assert free.budget.energies()["load_work"] == beside.budget.energies()["load_work"] != 0.0
    assert free.budget.reactions()["edge"] == pytest.approx(beside.budget.reactions()["edge"], rel=1e-12)
    assert free.budget.conservation()["momentum"] < 1e-12
    again = Simulation(Case.model_validate(table), threads=1)
    again.restore({name: array.copy() for name, array in free.state_arrays().items()}, free.state_numbers())
    advance(again, 5)
    advance(free, 5)
    assert np.array_equal(free.bodies[0].arrays["position"], again.bodies[0].arrays["position"])
