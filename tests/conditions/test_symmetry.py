"""Planes of symmetry: bodies between them follow the whole of which they are a part."""

import numpy as np
import pytest
from small_cases import SOLID, advance, assert_resumes, box, case
from solids import block_of

from pellucid.conditions.loads.forces import BodyForce
from pellucid.conditions.rotating_frame import RotatingFrame
from pellucid.conditions.support import Support
from pellucid.conditions.symmetry import mirrored_ends
from pellucid.grid.folding import Mirrored, Walled
from pellucid.grid.model import GridCase
from pellucid.simulation.simulation import Simulation

OIL = {"kind": "fluid", "density": 1.0, "viscosity": 0.3, "eos": {"kind": "tait", "sound_speed": 10.0}}
ROUNDING = 1e-11
"""Relative error after some tens of steps, in which differences of 1e-16 grow with the number of sums and the strain rates."""
NONE, LOWER, UPPER = (False, False), (True, False), (False, True)


def part_of_a_room(planes, body, extent, **more):
    """A room of eight cells along each axis but the last, centred at zero, with fixed walls along x or, for a part, planes of
    symmetry at zero; planes: names of the faces that are planes."""
    lower, upper = np.array([-4.0, -4.0, 0.0]), np.array([4.0, 4.0, 0.0])
    low, high = np.array(extent[0]), np.array(extent[1])
    for face in planes:
        axis = "xyz".index(face[0])
        (lower if face.endswith("lower") else upper)[axis] = 0.0
        (low if face.endswith("lower") else high)[axis] = 0.0
    walls = [f"{axis}-{end}" for axis in "xy" for end in ("lower", "upper") if f"{axis}-{end}" not in planes]
    counts = [max(round(n), 1) for n in upper - lower]
    held = [{"where": walls}, *([{"name": "planes", "where": planes, "fix": "normal"}] if planes else [])]
    block = box(low.tolist(), high.tolist(), body["material"], (2, 2, 1), **{k: v for k, v in body.items() if k != "material"})
    how = {"end": 100.0, "energy": {"warn": 0.5, "stop": 10.0}, "support": held} | more
    return Simulation(case(block, counts=counts, lower=lower.tolist(), **how), threads=1)


def stir(sim):
    """Give the points places off the lattice and a flow, both symmetric about x = 0 and y = 0; return the places."""
    body = sim.bodies[0]
    x, v = body.arrays["position"], body.arrays["velocity"]
    side, (a, b) = np.sign(x[:, :2]), np.abs(x[:, :2]).T
    x[:, 0] += side[:, 0] * 0.1 * np.sin(2.0 * a + b)
    x[:, 1] += side[:, 1] * 0.1 * np.sin(a + 3.0 * b)
    v[:, 0] += side[:, 0] * 0.4 * np.sin(a) * np.cos(0.7 * b)
    v[:, 1] += -side[:, 1] * 0.4 * np.sin(b) * np.cos(0.6 * a)
    body.storage.sort()
    return by_number(body, "position")


def by_number(body, name):
    return body.arrays[name][np.argsort(body.arrays["id"])]


def assert_follows(planes, steps, **how):
    """The body between planes of symmetry moves as that part of the whole body does."""
    part, whole = part_of_a_room(planes, **how), part_of_a_room([], **how)
    here, there = stir(part), stir(whole)
    same = np.array([np.argmin(np.abs(there - place).max(axis=1)) for place in here])
    assert np.abs(there[same] - here).max() < 1e-14
    assert isinstance(part.velocity_fields[0].grid.lattice.folding, Mirrored)
    advance(part, steps)
    advance(whole, steps)
    for name in ("position", "velocity", "stress", "volume"):
        of_whole = by_number(whole.bodies[0], name)
        assert np.abs(by_number(part.bodies[0], name) - of_whole[same]).max() < ROUNDING * np.abs(of_whole).max(), name


IN_FREE_SPACE = ((-3.0, -3.0, 0.0), (3.0, 3.0, 0.0))
FULL = ((-4.0, -4.0, 0.0), (4.0, 4.0, 0.0))


@pytest.mark.parametrize("material", [OIL, SOLID], ids=["fluid", "solid"])
@pytest.mark.parametrize("transfer", ["flip", "pic", "apic", "aflip"])
@pytest.mark.parametrize("functions", ["gimp", "quadratic-bspline", "cubic-bspline"])
def test_a_half_follows_the_whole(functions, transfer, material):
    """The functions of a wall at the plane make velocities wrong by 1 to 9 % within 40 steps."""
    how = {"functions": functions, "transfer": transfer, "step": 0.02}
    assert_follows(["y-lower"], 20, body={"material": material}, extent=IN_FREE_SPACE, **how)


@pytest.mark.parametrize("scheme", ["usl", "usf"])
@pytest.mark.parametrize("planes", [["x-upper"], ["x-lower", "y-upper"], ["x-upper", "y-lower"]])
@pytest.mark.parametrize("mass_matrix", ["lumped", "consistent"])
def test_a_part_follows_the_whole_at_any_end(planes, scheme, mass_matrix):
    how = {"functions": "quadratic-bspline", "transfer": "apic", "step": 0.02, "scheme": scheme, "mass_matrix": mass_matrix}
    assert_follows(planes, 20, body={"material": OIL}, extent=IN_FREE_SPACE, **how)


@pytest.mark.parametrize(
    ("implicit", "transfer", "even"),
    [
        ("implicit_viscosity", "flip", False),
        ("implicit_viscosity", "apic", False),
        ("implicit_pressure", "flip", False),
        ("implicit_pressure", "apic", True),
    ],
)
def test_a_quarter_follows_the_whole_with_implicit_forces(implicit, transfer, even):
    body = {"material": OIL | {implicit: True} | ({"even_points": True} if even else {})}
    body |= {"cell_pressure": True} if implicit == "implicit_pressure" else {}
    how = {"functions": "quadratic-bspline", "transfer": transfer, "step": 0.05, "scheme": "usl"}
    assert_follows(["x-lower", "y-lower"], 10, body=body, extent=FULL, **how)


def test_a_quarter_follows_the_whole_with_pressures_of_cells():
    """Also where empty cells beside a plane are holes within the fluid or lie outside it."""
    how = {"functions": "quadratic-bspline", "transfer": "flip", "step": 0.02}
    assert_follows(["x-lower", "y-lower"], 20, body={"material": OIL, "cell_pressure": True}, extent=IN_FREE_SPACE, **how)


def falling_on_a_plane(functions="quadratic-bspline", threads=1, **more):
    body = box((0, 0, 0), (3, 3, 3), OIL, velocity=(-0.5, -0.3, 0.2))
    planes = [{"name": "planes", "where": ["x-lower", "y-lower", "z-lower", "z-upper"], "fix": "normal"}]
    how = {"end": 100.0, "energy": {"warn": 0.5, "stop": 10.0}} | more
    return Simulation(case(body, counts=(5, 5, 3), functions=functions, support=planes, **how), threads=threads)


@pytest.mark.parametrize("transfer", ["flip", "pic", "apic", "aflip"])
@pytest.mark.parametrize("functions", ["gimp", "quadratic-bspline", "cubic-bspline"])
def test_momentum_and_energy_are_kept(functions, transfer):
    sim = advance(falling_on_a_plane(functions, transfer=transfer), 20)
    assert sim.budget.conservation()["momentum"] < 1e-13
    assert abs(sim.budget.conservation()["energy"]) < 1e-13
    assert np.all(sim.budget.reactions()["planes"][:2] > 0.0)


def test_threads_and_a_checkpoint_change_no_bit():
    one, several = (advance(falling_on_a_plane(transfer="apic", threads=n), 10) for n in (1, 2))
    for name, array in one.state_arrays().items():
        assert np.array_equal(array, several.state_arrays()[name]), name
    assert_resumes(falling_on_a_plane(transfer="apic"), falling_on_a_plane(transfer="apic"), 3, 5)


def test_half_a_channel_follows_the_whole_between_walls_of_shapes():
    """The walls lie half a cell from nodes, and sample the fluid beyond the plane."""
    flows = []
    for lower in (-4.0, 0.0):
        walls = [{"where": {"box": {"lower": [-1, 2.5, 0], "upper": [9, 9, 0]}}}]
        walls += [{"where": {"box": {"lower": [-1, -9, 0], "upper": [9, -2.5, 0]}}}] if lower else []
        walls += [] if lower else [{"where": "y-lower", "fix": "normal"}]
        oil = box((0, max(lower, -2.5), 0), (4, 2.5, 0), OIL, (2, 2, 1))
        how = {
            "functions": "quadratic-bspline",
            "transfer": "apic",
            "periodic": ["x"],
            "gravity": (0.1, 0.0, 0.0),
            "step": 0.02,
        }
        counts = (4, round(4.0 - lower), 1)
        sim = Simulation(case(oil, counts=counts, lower=(0.0, lower, 0.0), support=walls, end=100.0, **how), threads=1)
        body = advance(sim, 40).bodies[0]
        upper = by_number(body, "position")[:, 1] > 0.0
        order = np.lexsort(by_number(body, "position")[upper].round(6).T)
        flows.append(by_number(body, "velocity")[upper][order])
    assert np.abs(flows[1] - flows[0]).max() < ROUNDING * np.abs(flows[0]).max()


GRID = {"lower": (0, 0, 0), "upper": (4, 4, 0), "cell": 1.0, "functions": "quadratic-bspline"}


def ends_of(*supports, conditions=(), pull=(0.0, 0.0, 0.0), **grid):
    return mirrored_ends([Support(**one) for one in supports], conditions, GridCase(**(GRID | grid)), pull)


def test_smooth_faces_at_rest_mirror_the_functions():
    assert ends_of({"where": ["x-lower", "y-upper"], "fix": "normal"}) == (LOWER, UPPER, NONE)
    assert ends_of({"where": "x-lower", "fix": ["x"]}, {"where": "all-nodes", "fix": ["y"]}) == (LOWER, NONE, NONE)
    assert ends_of({"where": "x-lower", "fix": ["x", "z"]}) == (LOWER, NONE, NONE)  # the grid is thin along z


@pytest.mark.parametrize(
    "supports",
    [
        [{"where": "x-lower"}],
        [{"where": "x-lower", "fix": ["y"]}],
        [{"where": "x-lower", "fix": "normal"}, {"where": "x-lower", "fix": ["y"]}],
        [{"where": "x-lower", "fix": "normal", "friction": 0.1}],
        [{"where": "x-lower", "fix": "normal", "opens": True}],
        [{"where": "x-lower", "fix": "normal", "until": 1.0}],
        [{"where": "x-lower", "fix": "normal", "velocity": (0.1, 0, 0)}],
        [{"where": "x-lower", "fix": "normal", "body": "block"}],
        [{"where": {"box": {"lower": (0, 0, 0), "upper": (0, 4, 0)}}, "fix": ["x"]}],
    ],
)
def test_other_faces_do_not(supports):
    assert ends_of(*supports) == (NONE, NONE, NONE)


def test_floors_under_gravity_are_not_mirrored():
    """Water at rest would be off its pressure by a kink: by 0.7 % of that on the ground instead of 4e-6."""
    faces = {"where": ["x-lower", "y-lower"], "fix": "normal"}
    assert ends_of(faces, pull=(0.0, -9.81, 0.0)) == (LOWER, NONE, NONE)
    force = BodyForce(body="block", acceleration=(-1.0, 0.0, 0.0))
    assert ends_of(faces, conditions=[force], pull=(0.0, -9.81, 0.0)) == (NONE, NONE, NONE)
    assert ends_of(faces, conditions=[RotatingFrame(angular_velocity=(0.0, 1.0, 0.0))]) == (NONE, LOWER, NONE)
    assert ends_of(faces, conditions=[RotatingFrame(angular_velocity=(0.0, 0.0, 1.0))]) == (NONE, NONE, NONE)


def test_a_point_in_a_plane_stays_there():
    """Contributions of a node and its mirror image cancel up to rounding, and no point leaves the grid by it."""
    sim = falling_on_a_plane()
    body = sim.bodies[0]
    body.arrays["position"][:, 0] *= body.arrays["position"][:, 0] > 0.5
    body.storage.sort()
    first = body.arrays["position"][:, 0] == 0.0
    numbers = body.arrays["id"][first]
    advance(sim, 10)
    assert np.abs(body.arrays["position"][np.isin(body.arrays["id"], numbers), 0]).max() < 1e-14


def test_linear_functions_and_seams_are_not_mirrored():
    assert ends_of({"where": "x-lower", "fix": "normal"}, functions="trilinear") == (NONE, NONE, NONE)
    assert ends_of({"where": "x-lower", "fix": "normal"}, periodic=("x",)) == (NONE, NONE, NONE)


def test_fluids_without_viscosity_leave_the_functions_as_at_walls():
    """They have no shear stress, and gas and shocks stay as fast."""
    wall, eos = [{"where": "x-lower", "fix": "normal"}], {"kind": "tait", "sound_speed": 10.0}
    how = {"counts": (4, 4, 4), "functions": "quadratic-bspline", "support": wall}
    for viscosity, kind in ((0.0, Walled), (0.3, Mirrored)):
        water = {"kind": "fluid", "density": 1.0, "viscosity": viscosity, "eos": eos}
        sim = Simulation(case(box((0, 0, 0), (4, 4, 4), water), **how), threads=1)
        assert isinstance(sim.velocity_fields[0].grid.lattice.folding, kind)


def test_bodies_with_their_own_nodes_leave_the_functions_as_at_walls():
    """They account for the impulses of supports on their own nodes only."""
    wall, other = [{"where": "x-lower", "fix": "normal"}], box((0, 0, 0.15), (0.1, 0.1, 0.25), SOLID, name="other")
    how = {"counts": (8, 8, 8), "cell": 0.05, "functions": "gimp", "support": wall}
    for bodies, kind in (([other], Mirrored), ([block_of(field="own"), other], Walled)):
        sim = Simulation(case(*bodies, **how), threads=1)
        assert all(isinstance(field.grid.lattice.folding, kind) for field in sim.velocity_fields)
