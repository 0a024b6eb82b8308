"""Areas of walls at nodes: sums over a surface, also at edges."""

import numpy as np
import pytest
from small_cases import box, case

from pellucid.conditions.no_slip_walls import SLIP, NoSlipWall
from pellucid.simulation.simulation import Simulation

OIL = {"kind": "fluid", "density": 1.0, "viscosity": 1.0, "eos": {"kind": "tait", "sound_speed": 10.0, "carries_tension": True}}


def wall_of(shape, counts=(14, 14, 1), functions="quadratic-bspline"):
    upper = [count if count > 1 else 0 for count in counts]
    oil = box((0, 0, 0), upper, OIL, [2 if count > 1 else 1 for count in counts], name="oil")
    sim = Simulation(case(oil, counts=counts, support=[{"where": shape}], functions=functions, transfer="apic"), threads=1)
    return sim.parts.only(NoSlipWall)._wall


def block(offset, angle, size=(6.0, 5.0)):
    low = [7.0 + o - 0.5 * edge for o, edge in zip(offset, size, strict=True)]
    high = [a + edge for a, edge in zip(low, size, strict=True)]
    return {"box": {"lower": [*low, -9], "upper": [*high, 9]}, "rotate": {"axis": [0, 0, 1], "angle": angle}}


@pytest.mark.parametrize(("angle", "tolerance"), [(0.0, 1e-3), (30.0, 0.5), (45.0, 0.5)])
@pytest.mark.parametrize("offset", [(0.0, 0.0), (0.3, 0.17), (0.5, 0.5)])
def test_areas_of_a_block_add_up_to_its_perimeter(angle, tolerance, offset):
    """Lines lie a quarter of a cell apart: at each of four edges of an oblique block half a line is missing or too much. Added
    as vectors, the areas at four edges would be 1.5 to 2.5 cells too small."""
    wall = wall_of(block(offset, angle))
    assert wall.area.sum() == pytest.approx(22.0, abs=tolerance)


@pytest.mark.parametrize("functions", ["trilinear", "cubic-bspline"])
def test_areas_with_other_functions(functions):
    assert wall_of(block((0.3, 0.17), 0.0), functions=functions).area.sum() == pytest.approx(22.0, abs=0.01)


def test_areas_of_a_ball_and_a_cube():
    """In space: the area of a ball within 1 %, that of a cube within the samples at its edges."""
    ball = wall_of({"sphere": {"centre": [5.1, 5.2, 5.3], "radius": 3.0}}, (10, 10, 10))
    assert ball.area.sum() == pytest.approx(36.0 * np.pi, rel=0.01)
    cube = wall_of({"box": {"lower": [3, 3, 3], "upper": [7, 7, 7]}}, (10, 10, 10))
    assert cube.area.sum() == pytest.approx(96.0, rel=1e-3)


def test_plane_faces_beside_edges_have_no_curvature():
    """As a mean over the surface, the curvature of the edges of this block was 0.2 per cell on its plane faces also: it raised
    their traction by 40 %."""
    wall = wall_of(block((0.0, 0.0), 0.0))
    assert np.abs(wall.surface.curvature).max() < 0.05


@pytest.mark.parametrize("angle", [0.0, 30.0, 45.0])
@pytest.mark.parametrize("offset", [(0.0, 0.0), (0.3, 0.17), (0.5, 0.5)])
def test_edges_of_a_block(angle, offset):
    """The surface within half a cell of four convex edges, wherever they lie between the nodes. Lines are a quarter of a cell
    apart, and crossings with those along both axes count by half on oblique faces."""
    wall = wall_of(block(offset, angle))
    assert wall.slip.to_nodes.sum() == pytest.approx(4.0, abs=1e-2 if angle == 0.0 else 1.0)
    turned = np.radians(angle)
    turn = np.array([[np.cos(turned), -np.sin(turned)], [np.sin(turned), np.cos(turned)]])
    corners = [7.0 + np.array(offset) + turn @ [x, y] for x in (-3.0, 3.0) for y in (-2.5, 2.5)]
    at_edges = wall.place[wall.edge > 0.0, :2]
    assert np.linalg.norm(at_edges[:, None] - corners, axis=2).min(axis=1).max() < 2.0 * np.sqrt(2.0)


@pytest.mark.parametrize(
    "shape",
    [
        {"cylinder": {"centre": [7.1, 6.8, 0], "radius": 2.2}},
        {"pipe": {"centre": [7.1, 6.8, 0], "inner_radius": 3.0, "outer_radius": 20.0}},
    ],
)
def test_smooth_surfaces_have_no_edges(shape):
    """Radii of curvature of more than two cells."""
    assert not wall_of(shape).edge.any()


def test_concave_edges_are_none():
    """The velocity of a viscous fluid is not singular there."""
    floor, side = ({"box": {"lower": [-5, -5, -5], "upper": upper}} for upper in ([30, 3.3, 5], [3.7, 30, 5]))
    oil = box((0, 0, 0), (14, 14, 0), OIL, (2, 2, 1), name="oil")
    more = {"functions": "quadratic-bspline", "transfer": "apic", "support": [{"where": floor}, {"where": side}]}
    sim = Simulation(case(oil, counts=(14, 14, 1), **more), threads=1)
    assert not sim.parts.only(NoSlipWall)._wall.edge.any()


def test_a_ball_has_no_edges_and_a_cube_has_twelve():
    assert not wall_of({"sphere": {"centre": [5.1, 5.2, 5.3], "radius": 2.5}}, (10, 10, 10)).edge.any()
    cube = wall_of({"box": {"lower": [3, 3, 3], "upper": [7, 7, 7]}}, (10, 10, 10))
    assert cube.slip.to_nodes.sum() == pytest.approx(6.0 * (16.0 - 9.0), rel=0.01)


def test_curvature_of_a_disc_beside_a_plane_wall():
    shapes = [{"cylinder": {"centre": [7, 7, 0], "radius": 4.0}}, {"box": {"lower": [-1, -1, -1], "upper": [15, 3, 1]}}]
    oil = box((0, 0, 0), (14, 14, 0), OIL, (2, 2, 1), name="oil")
    more = {"functions": "quadratic-bspline", "transfer": "apic"}
    sim = Simulation(case(oil, counts=(14, 14, 1), support=[{"where": one} for one in shapes], **more), threads=1)
    wall = sim.parts.only(NoSlipWall)._wall
    top, plane = wall.place[:, 1] > 8.0, (wall.place[:, 1] < 3.6) & (np.abs(wall.place[:, 0] - 7.0) > 6.0)
    assert wall.surface.curvature[top] == pytest.approx(0.25, rel=0.15)
    assert wall.surface.curvature[plane] == pytest.approx(0.0, abs=0.05)


def test_the_velocity_at_edges_near_membranes_is_not_that_of_the_fluid():
    """A cell in a slit stopped for a tenth of its passage where its membrane, one and a half cells from an edge, moved the
    nodes at the edge: the friction of their slip held the cell."""
    oil = box((0, 0, 0), (14, 14, 0), OIL, (2, 2, 1), name="oil")
    supports = [{"where": block((0.3, 0.17), 0.0)}]
    more = {"functions": "quadratic-bspline", "transfer": "apic", "support": supports}
    wall = Simulation(case(oil, counts=(14, 14, 1), **more), threads=1).parts.only(NoSlipWall)
    mass = np.ones(len(wall._wall.window.node))
    assert np.all(wall._known_at_edges(mass, mass) == 1.0)
    wall._fluid.is_alone = False  # as in a field with a membrane
    for share, known in ((0.0, 1.0), (0.5 / SLIP, 0.5), (1.5 / SLIP, 0.0)):
        assert wall._known_at_edges(mass, (1.0 - share) * mass) == pytest.approx(known, abs=1e-12)
    wall._fluid.is_affine = False  # as with FLIP, whose nodes at a wall have the mean velocity of points beside it
    assert not wall._known_at_edges(mass, mass).any()
