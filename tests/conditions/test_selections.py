"""Supports and motions on regions of bodies with their own nodes: what they hold, their reactions, and what is refused."""

import warnings

import numpy as np
import pytest
from scipy.optimize import brentq
from small_cases import RATE_SOLID, box
from solids import block_of

from pellucid import loads
from pellucid.case import Case, dumps
from pellucid.errors import CaseError
from pellucid.geometry.solid_meshes.box import box_mesh
from pellucid.materials.elastic import lame
from pellucid.materials.law import energy, first_piola_kirchhoff
from pellucid.materials.neo_hookean import NeoHookean
from pellucid.running.launch import run_case
from pellucid.simulation.simulation import Simulation

TISSUE = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 3e3, "poisson_ratio": 0.3}
SKIN = {"kind": "linear-membrane", "density": 1000.0, "young_modulus": 1e6, "poisson_ratio": 0.3}
BLOCK = block_of(TISSUE, (2, 2, 2))
SHEET = {
    "name": "sheet",
    "kind": "membrane-elements",
    "field": "sheet",
    "surface": {"rectangle": {"corner": (0, 0, 0.2), "first_edge": (0.1, 0, 0), "second_edge": (0, 0.1, 0), "points": (5, 5)}},
    "thickness": 0.001,
    "material": SKIN,
}
GRID = {"lower": (-0.1, -0.1, -0.1), "upper": (0.3, 0.3, 0.3), "cell": 0.05}
UP = {"normal": (0, 0, 1), "within": 30}
DOWN = {"normal": (0, 0, -1)}
AWAY = {"sphere": {"centre": (9, 9, 9), "radius": 1}}


def made(*bodies, **more):
    table = {"schema": 1, "title": "a test", "time": {"end": 1.0}, "body": list(bodies)} | more
    return Case.model_validate(table)


def run(steps=20, *bodies, **more):
    simulation = Simulation(made(*(bodies or (BLOCK,)), **more), threads=1)
    for _ in range(steps):
        simulation.step()
    return simulation


def pull(part, **more):
    rise = {"kind": "ramp", "distance": 0.01, "duration": 0.5}
    return {"name": "pull", "body": "block", "part": part, "hold": ("x", "y"), "displacement": {"z": rise}} | more


@pytest.fixture(scope="module")
def pulled():
    return run(60, support=[{"name": "bottom", "body": "block", "where": DOWN}], motion=[pull(UP)])


def test_the_nodes_of_a_region_are_held_and_moved(pulled):
    (body,) = pulled.bodies
    start, now = body.mesh.nodes, body.arrays["position"]
    top, bottom = np.isclose(start[:, 2], 0.1), np.isclose(start[:, 2], 0.0)
    assert np.array_equal(body.arrays["prescribed"].any(axis=1), top | bottom)
    assert np.array_equal(now[bottom], start[bottom])
    risen = now[top, 2] - start[top, 2]
    assert risen.max() > 1e-4
    assert risen == pytest.approx(risen[0], abs=1e-15)


def test_reactions_of_regions_are_the_change_of_momentum(pulled):
    """The impulses of the support and the motion, each by its name, are the momentum of the body."""
    reactions, scale = pulled.budget.reactions(), pulled.budget.momentum_scale
    assert reactions["pull"][2] > 0.1 * scale
    assert pulled.momentum() == pytest.approx(reactions["pull"] + reactions["bottom"], abs=1e-13 * scale)
    energies = pulled.budget.energies()
    assert energies["support_work"] == 0.0, "it holds still"
    assert abs(energies["transfer_error"]) < 1e-14 * energies["motion_work"], "the works are the change of kinetic energy"
    # the error of central differences in their energy: of first order in the step, a twentieth of the ramp
    assert energies["kinetic"] + energies["strain"] == pytest.approx(energies["motion_work"], rel=0.05)


def test_probes_find_the_reactions_of_an_equilibrium(tmp_path):
    """A bar between planes of symmetry and a face that is moved up: the nominal stress on the area, pulled both ways."""
    law, area = NeoHookean(*lame(3e3, 0.3), 1000.0), 0.01
    lower = [
        {"name": axis, "body": "block", "where": {"normal": tuple(-np.eye(3)[n])}, "fix": [axis]}
        for n, axis in enumerate("xyz")
    ]
    reaction = {"quantity": "reaction", "component": "z"}
    case = made(
        BLOCK,
        support=lower,
        motion=[{k: v for k, v in pull(UP).items() if k != "hold"}],
        probe=[{"name": "up", "condition": "pull", **reaction}, {"name": "down", "condition": "z", **reaction}],
        steady={"tolerance": 1e-8, "load_steps": 2},
        output={"history": 0.5},
    )
    run = run_case(case, tmp_path / "out", threads=1, report=False)
    across = brentq(lambda a: first_piola_kirchhoff(law, (a, 0.0, 0.0, 0.0, a, 0.0, 0.0, 0.0, 1.1))[0], 0.9, 1.0)
    F = (across, 0.0, 0.0, 0.0, across, 0.0, 0.0, 0.0, 1.1)
    force = first_piola_kirchhoff(law, F)[8] * area
    assert run.history["up"][-1] == pytest.approx(force, rel=1e-6)
    assert run.history["down"][-1] == pytest.approx(-force, rel=1e-6)
    assert run.history["strain_energy"][-1] == pytest.approx(energy(law, F) * 1e-3, rel=1e-6)


def test_a_support_of_one_body_leaves_others_and_the_grid_alone():
    """The patch of the block is held; the sheet falls freely, as do the nodes of the grid that it meets."""
    more = {"grid": GRID, "gravity": (0, 0, -10), "support": [{"name": "patch", "body": "block", "where": UP}]}
    simulation = run(10, BLOCK | {"field": "block"}, SHEET, **more)
    block, sheet = simulation.bodies
    top = np.isclose(block.mesh.nodes[:, 2], 0.1)
    assert np.array_equal(block.arrays["position"][top], block.mesh.nodes[top])
    assert sheet.arrays["velocity"][:, 2] == pytest.approx(-10.0 * simulation.time, rel=1e-12)
    assert not any(actions.field.grid.nodes.constrained.any() for actions in simulation.actions)
    assert simulation.budget.conservation()["momentum"] < 1e-12


def test_the_rim_of_a_membrane_is_held():
    sim = run(10, SHEET, gravity=(0, 0, -10), support=[{"body": "sheet", "where": "boundary"}])
    (sheet,) = sim.bodies
    x = sheet.surface.vertices
    rim = (np.isclose(x[:, :2], 0.0) | np.isclose(x[:, :2], 0.1)).any(axis=1)
    assert np.array_equal(sheet.arrays["velocity"][rim], np.zeros((rim.sum(), 3)))
    assert (sheet.arrays["velocity"][~rim, 2] < 0.0).all()


def test_the_rim_of_a_membrane_of_points_is_moved():
    """Its points are sorted by cell: the rim is theirs whatever their order."""
    hold = {"name": "rim", "body": "sheet", "part": "boundary", "hold": ["x", "y", "z"]}
    sheet = {k: v for k, v in SHEET.items() if k != "field"} | {"kind": "membrane-points"}
    sim = run(1, sheet, grid=GRID, gravity=(0, 0, -10), motion=[hold])
    points = sim.bodies[0].frame()
    rim = (np.isclose(points["position"][:, :2], 0.0) | np.isclose(points["position"][:, :2], 0.1)).any(axis=1)
    assert rim.sum() == 16
    assert not np.array_equal(sim.bodies[0].arrays["id"], np.arange(25)), "they are sorted"
    driven = np.zeros(25, bool)
    driven[sim.bodies[0].arrays["id"]] = sim.bodies[0].arrays["driven"] > 0
    assert np.array_equal(driven, rim)


def test_a_sphere_constrains_the_nodes_of_the_grid_and_of_bodies():
    ball = {"sphere": {"centre": (0, 0, 0), "radius": 0.06}}
    simulation = run(1, grid=GRID, support=[{"where": ball}])
    (actions,), (block,) = simulation.actions, simulation.bodies
    index, position = actions.field.grid.where()
    inside = np.linalg.norm(position, axis=1) <= 0.06
    assert inside.sum() == 7
    assert np.array_equal(actions.field.grid.nodes.constrained[index].any(axis=1), inside)
    held = np.linalg.norm(block.mesh.nodes, axis=1) <= 0.06
    assert np.array_equal(block.arrays["prescribed"].any(axis=1), held)


def test_a_box_between_the_nodes_of_the_grid_may_hold_a_body():
    slab = {"box": {"lower": (-1, -1, 0.0999), "upper": (1, 1, 0.1001)}}
    grid = GRID | {"cell": 0.04}
    simulation = run(1, grid=grid, support=[{"where": slab}])
    (body,) = simulation.bodies
    assert np.array_equal(body.arrays["prescribed"].any(axis=1), np.isclose(body.mesh.nodes[:, 2], 0.1))


def test_a_named_set_of_a_file_holds_its_nodes(tmp_path):
    meshlane = pytest.importorskip("meshlane")
    mesh = box_mesh(np.zeros(3), np.full(3, 0.1), (2, 2, 2))
    bottom = np.flatnonzero(mesh.nodes[:, 2] == 0.0)
    path = tmp_path / "box.inp"
    meshlane.write(str(path), meshlane.Mesh(mesh.nodes, [("tetra", mesh.cells)], point_sets={"bottom": bottom}))
    body = BLOCK | {"mesh": {"file": {"path": str(path)}}}
    simulation = run(5, body, support=[{"body": "block", "where": {"set": "bottom"}}], motion=[pull(UP)])
    assert np.array_equal(np.flatnonzero((simulation.bodies[0].arrays["prescribed"] == 1).all(axis=1)), bottom)
    with pytest.raises(ValueError, match="no set of this name; its sets are bottom"):
        made(body, motion=[pull({"set": "botom"})])


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"support": [{"where": {"set": "top"}}]}, "the mesh of body block has no named sets"),
        ({"support": [{"body": "blok", "where": UP}]}, "no body has this name; available names: block"),
        ({"support": [{"body": "block", "where": {"set": "top"}}]}, "the mesh of body block has no named sets"),
        ({"support": [{"body": "block", "where": AWAY}]}, "no node of body block lies in it at the start"),
        ({"motion": [pull(AWAY)]}, "no node of body block lies in it at the start"),
        ({"motion": [pull({"normal": (0, 0, 1), "set": "top"})]}, "has no named sets"),
    ],
)
def test_regions_without_a_node_are_refused_when_the_case_is_read(more, words):
    with pytest.raises(ValueError, match=words):
        made(BLOCK, **more)


def test_a_support_on_a_part_of_a_mesh_is_that_of_the_only_body():
    for where in (DOWN, "boundary"):
        named, plain = ({"where": where} | more for more in ({"body": "block"}, {}))
        one, other = (run(2, support=[support], gravity=(0, 0, -10)).bodies[0] for support in (named, plain))
        assert one.arrays["prescribed"].any()
        assert other.arrays["prescribed"].tobytes() == one.arrays["prescribed"].tobytes()
    with pytest.raises(ValueError, match="belong to a body, and the case has block, sheet"):
        made(BLOCK | {"field": "block"}, SHEET, grid=GRID, support=[{"where": DOWN}])


@pytest.mark.parametrize("name", ["bottom", None])
def test_a_motion_that_overrules_a_support_is_told_with_both_and_how_many_nodes(name):
    """The support holds a side, the motion lifts the top; three nodes are on the edge between them."""
    side = {"name": name, "where": {"normal": (1, 0, 0)}}
    who = "support `bottom`" if name else "support number 1"
    words = (
        rf"{who} and motion `pull` prescribe different velocities along z at 3 nodes of body block: the motion is used there"
    )
    with pytest.warns(UserWarning, match=words) as caught:
        simulation = run(3, support=[side], motion=[pull(UP)])
    assert len(caught) == 1, "once, and not along x and y, where both hold still"
    (body,) = simulation.bodies
    edge = np.isclose(body.mesh.nodes[:, (0, 2)], 0.1).all(axis=1)
    assert edge.sum() == 3
    assert (body.arrays["position"][edge, 2] > 0.1).all()


def test_a_support_and_a_motion_that_agree_or_do_not_meet_are_not_told():
    plane = {"where": {"normal": (1, 0, 0)}, "fix": ["x"]}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run(3, support=[plane, {"where": DOWN}], motion=[pull(UP)])
        moved = {"where": UP, "fix": ["z"], "velocity": (0.0, 0.0, 0.1)}
        steady = {"displacement": {"z": {"kind": "steady", "velocity": 0.1}}, "hold": ()}
        run(3, support=[moved], motion=[pull(UP, **steady)])


def test_without_a_grid_a_support_that_meets_no_body_is_refused():
    with pytest.raises(ValueError, match=r"support\.0\.where(.|\n)*no node of a body lies in it"):
        made(BLOCK, support=[{"where": AWAY}])
    made(BLOCK, support=[{"where": {"sphere": {"centre": (0, 0, 0), "radius": 1}}}])


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"support": [{"body": "lump", "where": "all-nodes"}]}, "body lump has no nodes of its own"),
        ({"support": [{"where": UP}]}, "body with nodes of its own, but lump moves with the nodes of the grid"),
        ({"support": [{"where": "boundary"}]}, "body with nodes of its own, but lump moves with the nodes of the grid"),
        ({"motion": [pull(UP, body="lump")]}, "body lump has no mesh of its own, so it has no sets"),
    ],
)
def test_bodies_on_the_grid_are_told_apart(more, words):
    lump = box((0, 0, 0), (0.1, 0.1, 0.1), RATE_SOLID, name="lump")
    with pytest.raises((CaseError, ValueError), match=words):
        Simulation(made(lump, grid=GRID, **more), threads=1)


@pytest.mark.parametrize(
    ("where", "words"),
    [
        ("{ }", "a region is a table with a shape"),
        ("{ box = { lower = [0, 0, 0], upper = [1, 1, 1] }, sphere = { centre = [0, 0, 0], radius = 1 } }", "only one shape"),
        ("{ spere = { centre = [0, 0, 0], radius = 1 } }", "did you mean `sphere`"),
        ('"boundry"', "did you mean `boundary`"),
    ],
)
def test_what_is_written_wrongly_is_told_as_a_user_wrote_it(where, words):
    text = dumps(made(BLOCK)) + f'[[support]]\nbody = "block"\nwhere = {where}\n'
    with pytest.raises(CaseError, match=rf"support\.0\.where(.|\n)*{words}"):
        loads(text, "case.toml")
