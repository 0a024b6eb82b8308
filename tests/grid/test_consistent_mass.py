"""The consistent mass matrix in the momentum equation of the nodes."""

import numpy as np
import pytest
from small_cases import (
    SLIP,
    SOLID,
    advance,
    assert_resumes,
    assert_same_arrays,
    box,
    case,
    copied_state,
    finished,
    simulation,
)

from pellucid.grid.transfer import apply_mass_matrix
from pellucid.running.step_number import limit_of_model
from pellucid.simulation.simulation import Simulation

LIQUID = {"kind": "fluid", "density": 1.0, "eos": {"kind": "tait", "sound_speed": 1.0, "carries_tension": True}}
SPLINES = {"functions": "quadratic-bspline"}
AFFINE = [{"transfer": "apic"}, {"transfer": "aflip", "flip_fraction": 1.0}]


def frequency(n, mass_matrix, **how):
    """Frequency of a standing wave of sound over n cells, from its first zero to its third, over the exact frequency."""
    k = 2.0 * np.pi / n
    wave = {"kind": "sine-wave", "amplitude": (1e-4, 0, 0), "wave_vector": (k, 0, 0)}
    body = box((0, 0, 0), (n, 1, 1), LIQUID, (4, 1, 1), "liquid", initial=[wave])
    how = SPLINES | {"counts": (n, 1, 1), "courant": 0.1, "end": 1.5 * n, "periodic": ["x"]} | how
    sim = simulation(body, mass_matrix=mass_matrix, **how)
    (body,), times, sizes, zeros = sim.bodies, [0.0], [], []
    shape = np.sin(k * body.field("position")[:, 0])
    sizes.append(np.mean(shape * body.field("velocity")[:, 0]))
    while len(zeros) < 3:
        sim.step()
        times.append(sim.time)
        sizes.append(np.mean(shape * body.field("velocity")[:, 0]))
        if sizes[-2] * sizes[-1] < 0.0:
            zeros.append(times[-1] - sizes[-1] * (times[-1] - times[-2]) / (sizes[-1] - sizes[-2]))
    return 2.0 * np.pi / (zeros[2] - zeros[0]) / k


@pytest.mark.parametrize("how", AFFINE, ids=["apic", "aflip"])
def test_frequencies_of_waves_are_of_fourth_order(how):
    """Points see a share s = (sin(kh/2)/(kh/2))⁶ of the stiffness. With lumped masses the frequency has the factor √s, with an
    error k²h²/8; with the first terms of the inverse of the consistent matrix √(s (2 - s)), with k⁴h⁴/32. The transfers have an
    error of k⁴h⁴ too: 0.6 % for 8 cells."""
    for kind, order in (("lumped", 2.0), ("consistent", 4.0)):
        errors = []
        for n in (8, 16):
            s = np.sinc(1.0 / n) ** 6
            share = s if kind == "lumped" else s * (2.0 - s)
            errors.append(frequency(n, kind, **how) - 1.0)
            assert errors[-1] == pytest.approx(np.sqrt(share) - 1.0, abs=0.008 * (8.0 / n) ** 4 + 3e-4)
        assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.5)  # time steps have an error of 3e-4


def some_liquid(viscosity=0.01, **more):
    """In a corner, with random velocities and a free surface."""
    body = box((0, 0, 0), (6, 5, 1), LIQUID | {"viscosity": viscosity}, (2, 2, 1), "liquid")
    walls = [wall | {"name": name} for name, wall in zip(("left", "right", "floor"), SLIP, strict=False)]
    how = SPLINES | {"counts": (9, 9, 1), "transfer": "aflip", "support": walls, "mass_matrix": "consistent"} | more
    sim = simulation(body, **how)
    place = sim.bodies[0].arrays["position"]
    velocity = sim.bodies[0].arrays["velocity"]
    velocity[:, 0] = 0.02 * np.sin(1.3 * place[:, 0] + 2.1 * place[:, 1])
    velocity[:, 1] = 0.02 * np.cos(2.3 * place[:, 0] - 0.7 * place[:, 1])
    kinetic = 0.5 * sim.bodies[0].arrays["mass"] @ np.sum(velocity**2, axis=1)
    momentum = sim.bodies[0].arrays["mass"] @ velocity
    sim.bodies[0].totals.kinetic, sim.bodies[0].totals.momentum = kinetic, momentum
    sim.begin_balance()
    return sim


def test_the_matrix_is_symmetric_and_its_rows_sum_to_the_lumped_masses():
    sim = advance(
        some_liquid(support=(), counts=(12, 12, 1), lower=(-3, -3, 0)), 1
    )  # planes of symmetry add to the nodes in them
    nodes, body, chance = sim.grid.nodes, sim.bodies[0], np.random.default_rng(1)

    def times(vector):
        product = np.zeros((len(nodes.mass), 3))
        apply_mass_matrix(body.n_slabs, body.mapped, vector, product)
        return product

    one, two = chance.normal(size=(2, len(nodes.mass), 3))
    assert np.sum(one * times(two)) == pytest.approx(np.sum(two * times(one)), rel=1e-12)
    sim.stages.clear_nodes()
    sim.stages.particle_to_grid(inertia=True, force=False)
    assert times(np.ones_like(one)) == pytest.approx(np.repeat(nodes.mass[:, None], 3, axis=1), abs=1e-14)


@pytest.mark.parametrize("scheme", ["musl", "usl", "usf"])
@pytest.mark.parametrize("how", AFFINE, ids=["apic", "aflip"])
def test_mass_momentum_and_energy_balance(scheme, how):
    """The supports exert what the matrix would give to the nodes that they hold: their reactions are all that acts."""
    sim = some_liquid(scheme=scheme, end=3.0, **how)
    before = sim.momentum()
    finished(sim)
    found = sim.budget.conservation()
    assert found["momentum"] < 1e-13
    assert abs(found["energy"]) < 1e-12
    assert sim.budget.energies()["mass_matrix_work"] != 0.0
    given = sum(sim.budget.reactions().values())
    size = float(sim.bodies[0].totals.momentum_size)
    assert given[:2] == pytest.approx((sim.momentum() - before)[:2], abs=1e-13 * size)


def test_solids_keep_their_energy():
    """Twice the energy that the matrix exchanges with the affine fields is a hundredth of what moves; with lumped masses a
    five-hundredth is lost in the integration in time."""
    block = box((3, 3, 0), (9, 6, 1), SOLID, (3, 3, 1), initial=[{"kind": "velocity-gradient", "x": (0.02, 0, 0)}])
    sim = finished(simulation(block, counts=(12, 9, 1), transfer="aflip", mass_matrix="consistent", end=10.0, **SPLINES))
    assert abs(sim.budget.energy_error()) < 0.01
    assert sim.budget.conservation()["momentum"] < 1e-13


@pytest.mark.parametrize("how", AFFINE, ids=["apic", "aflip"])
def test_the_largest_steps_are_stable(how):
    """Without viscosity, at a free surface: kinetic energy grows in no step of a cell per wave speed."""
    sim = some_liquid(viscosity=0.0, courant=1.0, end=60.0, energy={"stop": 100.0}, **how)
    begun = sim.budget.kinetic
    finished(sim)
    assert sim.budget.kinetic < begun


def test_the_stable_step_is_known_before_the_run():
    """1/√2 of that with lumped masses, or half of it with much viscosity."""
    for viscosity, share in ((0.0, 0.5**0.5), (10.0, 0.5)):
        lumped, consistent = (some_liquid(viscosity, mass_matrix=kind) for kind in ("lumped", "consistent"))
        limit = lumped.step_limit()[0]
        assert consistent.step_limit()[0].step == pytest.approx(share * limit.step, rel=1e-12)
        assert limit_of_model(consistent.case).step == pytest.approx(share * limit_of_model(lumped.case).step, rel=1e-12)
        with pytest.raises(ValueError, match=r"largest stable step.*with the consistent mass matrix"):
            some_liquid(viscosity, step=0.9 * limit.step)


def test_threads_do_not_change_a_bit():
    one, two = (copied_state(advance(some_liquid(threads=threads), 20)) for threads in (1, 2))
    assert_same_arrays(one, two)


def test_it_resumes_bit_for_bit():
    assert_resumes(some_liquid(), some_liquid(), 10, 10)


def test_lumped_masses_are_the_default_and_have_no_entry():
    sim = some_liquid(mass_matrix="lumped")
    assert "mass_matrix_work" not in sim.budget.energies()
    assert Simulation(case(box((0, 0, 0), (2, 2, 2))), threads=1).case.time.mass_matrix == "lumped"


RUBS = [{"where": "y-lower", "fix": "normal", "friction": 0.3}]
VISCOUS = LIQUID | {"viscosity": 1.0, "implicit_viscosity": True}


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"transfer": "flip"}, r'transfer "flip" smooths'),
        ({"functions": "gimp"}, r"not available with gimp"),
        ({"material": VISCOUS}, r"body liquid has implicit viscosity"),
        ({"support": RUBS}, r"walls that rub or open, such as `support.0`"),
        ({"motion": [{"body": "liquid", "name": "push", "hold": ["x"]}]}, r"prescribed motion"),
        ({"material": SOLID, "rigid": True}, r"rigid bodies, such as liquid"),
    ],
)
def test_what_is_not_included_is_an_error_of_the_case(keys, words):
    material, rigid = keys.pop("material", LIQUID), {"rigid": True} if keys.pop("rigid", False) else {}
    body = box((0, 0, 0), (2, 2, 1), material, (2, 2, 1), "liquid", **rigid)
    with pytest.raises(ValueError, match=r"(?s)time\.mass_matrix.*" + words):
        case(body, counts=(4, 4, 1), **(SPLINES | {"transfer": "apic", "mass_matrix": "consistent"} | keys))
