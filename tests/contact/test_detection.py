"""Where two fields meet: nodes, normals and distances of bodies whose faces are known. Cells of 1 m."""

from functools import partial

import numpy as np
import pytest
from membranes import sheet
from small_cases import GAS, box, place, simulation

from pellucid.contact.pairs import ContactPairs

box = partial(box, material=GAS)  # of which others ask the nodes; solids touch by their surfaces
CENTRE = np.array([4.0, 4.0, 4.0])


def met(*bodies, turn=None, **more):
    """How two bodies meet, their points turned about CENTRE; the places of the common nodes [m]; the sim."""
    sim = simulation(*bodies, **more)
    sim.stages.clear_nodes()
    for body in sim.bodies:
        if turn is not None:
            place(body, CENTRE + (body.arrays["position"] - CENTRE) @ turn.T)
        body.particle_to_grid(inertia=True, force=False)
    sim.stages.find_contact()
    index, position = sim.grid.where()
    places = np.full((sim.grid.n_nodes, 3), np.nan)
    places[index] = position
    meeting = sim.parts.only(ContactPairs)._pairs[0].detection
    return meeting, places[meeting.node], sim


@pytest.mark.parametrize("way", [1, -1])
def test_flat_faces_meet_at_the_nodes_of_both(way):
    """Overlapping by 0.02 m."""
    bodies = [box((1, 1, 1), (3, 3, 2), name="one", field="a"), box((1, 1, 1.98), (3, 3, 2.98), name="two")]
    meeting, position, _ = met(*bodies[::way])
    assert sorted(map(tuple, position)) == [(x, y, 2.0) for x in (1.0, 2.0, 3.0) for y in (1.0, 2.0, 3.0)]
    assert meeting.normal == pytest.approx(np.tile((0.0, 0.0, way), (9, 1)), abs=1e-12)
    assert meeting.gap == pytest.approx(-0.02, abs=1e-12)


def test_faces_apart_share_nodes_but_do_not_touch():
    meeting, _, _ = met(box((1, 1, 1), (3, 3, 2), name="one", field="a"), box((1, 1, 2.3), (3, 3, 3.3), name="two"))
    assert meeting.gap == pytest.approx(np.full(9, 0.3), abs=1e-12)
    assert not meeting.normal.any()


THICK, THIN = [(9, 8, 8), (8, 9, 8), (8, 8, 9)], [(8, 1, 9), (1, 9, 8), (8, 8, 1), (1, 1, 9)]


@pytest.mark.parametrize(
    ("functions", "counts"),
    [*(("trilinear", counts) for counts in THICK + THIN), *(("quadratic-bspline", counts) for counts in [*THICK, (8, 8, 1)])],
)
def test_points_are_looked_for_where_they_may_reach_the_shared_nodes(functions, counts):
    """In any order of the axes in memory, and where some are thin."""
    flat = np.array(counts) == 1
    corners = [
        (np.where(flat, 0, low), np.where(flat, 1, high)) for low, high in (((2, 3, 1), (4, 4, 3)), ((4, 3, 3), (6, 6, 5)))
    ]
    bodies = box(*corners[0], name="one", field="a"), box(*corners[1], name="two")
    meeting, position, sim = met(*bodies, counts=counts, functions=functions)
    stencil = np.array([function.stencil for function in sim.bodies[0].functions])
    assert len(position)
    assert meeting._box[0] == pytest.approx(position.min(axis=0) - 0.5 * stencil, abs=1e-5)
    assert meeting._box[1] == pytest.approx(position.max(axis=0) + 0.5 * stencil, abs=1e-5)


def test_tilted_faces_have_the_normal_of_their_gradients():
    s, c = np.sin(0.3), np.cos(0.3)
    turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    bodies = box((2, 2, 2), (6, 6, 4), name="one", field="a"), box((2, 2, 4), (6, 6, 6), name="two")
    meeting, position, _ = met(*bodies, turn=turn, counts=(8, 8, 8))
    within = np.abs((position - CENTRE) @ turn).max(axis=1) < 1.0 + 1e-9  # of the faces, whose edges lie at 2
    assert within.sum() == 9
    angle = np.degrees(np.arccos(meeting.normal[within] @ turn[:, 2]))
    assert angle.max() < 2.0  # eight points a cell sample a tilted gradient by 1.4 degrees
    # the half widths of points are those of cubes along the axes: foremost points of faces that touch overlap a little
    assert np.abs(meeting.gap[within]).max() < 0.05


def test_a_ball_above_a_plane_touches_at_its_lowest_point():
    ball = box((0, 0, 0), (1, 1, 1), per_cell=(3, 3, 3)) | {"shape": {"sphere": {"centre": [4, 4, 5.47], "radius": 1.5}}}
    meeting, position, sim = met(box((1, 1, 2), (7, 7, 4), name="plane", field="a"), ball, counts=(8, 8, 8))
    points = sim.bodies[1].points
    lowest = np.argmin(points.position[:, 2])
    beneath = np.flatnonzero(np.all(position == CENTRE, axis=1))
    assert meeting.normal[beneath] == pytest.approx(np.array([[0.0, 0.0, 1.0]]), abs=1e-12)
    expected = points.position[lowest, 2] - 0.5 * np.cbrt(points.volume[lowest]) - 4.0
    assert meeting.gap[beneath] == pytest.approx(expected, abs=1e-12)
    assert abs(expected) < 0.01
    beyond = np.hypot(*(position - CENTRE)[:, :2].T) > 1.9
    # at two cells from the axis the ball lies 0.6 m above the plane where it reaches furthest in
    assert beyond.sum() == 12
    assert meeting.gap[beyond].min() > 0.5
    assert not meeting.normal[beyond].any()


@pytest.mark.parametrize("above", [True, False])
@pytest.mark.parametrize("way", [1, -1])
def test_a_smooth_membrane_gives_the_normal_and_a_crumpled_one_takes_that_of_the_volume(way, above):
    """A sheet 0.12 m above or below a block, flat, tilted a little, and folded into steep pleats of half its length."""
    surface = {"rectangle": {"corner": [1.5, 1.5, 3.9], "first_edge": [5, 0, 0], "second_edge": [0, 5, 0], "points": [11, 11]}}
    cloth = sheet(kind="membrane-elements", surface=surface) | {"name": "cloth"}
    side = 1.0 if above else -1.0
    bodies = [box((1, 1, 2) if above else (1, 1, 4), (7, 7, 4) if above else (7, 7, 6), name="block", field="a"), cloth]

    def shaped(share, slope):
        sim = simulation(*bodies[::way], counts=(8, 8, 8))
        body = next(body for body in sim.bodies if body.name == "cloth")
        x = body.arrays["position"].copy()
        pleat = np.rint((x[:, 0] - 1.5) / 0.5) % 2
        x[:, 0] = 4.0 + share * (x[:, 0] - 4.0)
        x[:, 2] = 4.0 + side * (0.12 + slope * (x[:, 0] - 4.0) + 0.5 * np.sqrt(1.0 - share**2) * pleat)
        place(body, x)
        sim.stages.clear_nodes()
        sim.stages.grid_bodies[0].particle_to_grid(inertia=True, force=False)
        sim.stages.nodal_bodies[0].predict(0.0)
        meeting = sim.parts.only(ContactPairs)._pairs[0].detection
        meeting._close = np.inf
        sim.stages.find_contact()
        index, position = sim.grid.where()
        places = np.full((sim.grid.n_nodes, 3), np.nan)
        places[index] = position
        inner = np.all(np.abs(places[meeting.node] - 4.0) < (1.1, 2.1, 0.1), axis=1)
        assert inner.sum() == 15
        return way * side * meeting.normal[inner], meeting.gap[inner]

    normal, gap = shaped(1.0, 0.02)
    expected = np.array((-0.02, 0.0, side)) / np.hypot(1.0, 0.02)
    assert normal == pytest.approx(np.tile(side * expected, (15, 1)), abs=1e-9)
    for share in (1.0, 0.5):
        normal, gap = shaped(share, 0.0)
        assert normal == pytest.approx(np.tile((0.0, 0.0, 1.0), (15, 1)), abs=1e-9)
        # the sheet is 0.01 m thick, and the block's foremost points are cubes to its face
        assert gap == pytest.approx(np.full(15, 0.115), abs=1e-9)
