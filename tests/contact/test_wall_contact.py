"""A plane without a body, and what points of a surface feel of it."""

import numpy as np
import pytest

from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.images import describe
from pellucid.contact.overlap import STICKS
from pellucid.contact.wall import WallContact
from pellucid.contact.wall_plane import WallPlane


class Points(ContactSurface):
    """Three points: one that faces a floor, one on the side of a body across it, and one beneath that faces away."""

    mass_per_area, rate, follows_steps = 50.0, 20.0, False

    def __init__(self, height=-0.01):
        self.place = np.array([[0.0, height, 0.0], [1.0, height, 0.0], [2.0, height, 0.0]])
        self.area = 0.5 * np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
        self.velocity, self.slip = np.zeros((3, 3)), np.zeros((3, 3))
        self.reach = np.ones(3)
        self.given = np.zeros((3, 3))

    def add_forces(self, force):
        self.given += force


STIFFNESS = 50.0 * 20.0**2


def pushed(surface, plane, friction=0.0, dt=0.1, last=0.1):
    """The contact, and the forces on the points of a surface that touches a plane, above which it was at the start."""
    contact = WallContact(surface, plane, friction, courant=1.0)
    surface.place[:, 1] += 1.0
    contact.find({id(surface): describe(surface, [])})
    surface.place[:, 1] -= 1.0
    forces, touched = {id(surface): np.zeros((3, 3))}, {id(surface): np.zeros(3, bool)}
    if contact.find({id(surface): describe(surface, [])}):
        contact.push(dt, last, forces, touched)
    return contact, forces[id(surface)]


def floor(velocity=(0, 0, 0)):
    return WallPlane((7.0, 0.0, 3.0), (0.0, 2.0, 0.0), velocity)


def test_the_pressure_of_the_depth_acts_on_what_faces_the_plane():
    contact, force = pushed(Points(-0.01), floor())
    assert force == pytest.approx(np.array([[0, STIFFNESS * 0.01 * 0.5, 0], [0, 0, 0], [0, 0, 0]]), rel=1e-12)
    assert contact.impulse == pytest.approx([0.0, 0.1 * force[0, 1], 0.0])
    assert contact.external_work() == 0.0


def test_nothing_acts_above_the_plane_but_on_what_reaches_beyond_its_points():
    surface = Points(0.01)
    assert not pushed(surface, floor())[1].any()
    surface.half_width = 0.03
    assert pushed(surface, floor())[1][0, 1] == pytest.approx(STIFFNESS * 0.02 * 0.5)


def test_both_sides_of_a_membrane_touch_it():
    surface = Points()
    surface.two_sided = True
    force = pushed(surface, floor())[1]
    assert force[2] == pytest.approx(force[0])
    assert force[1] == pytest.approx(force[0]), "however it is folded"


def test_damping_resists_the_approach_and_never_pulls():
    surface = Points()
    damper = 2.0 * Points.damping * np.sqrt(STIFFNESS * 50.0) * 0.5
    surface.velocity[0] = (0.0, -0.3, 0.0)
    assert pushed(surface, floor())[1][0, 1] == pytest.approx(STIFFNESS * 0.01 * 0.5 + 0.3 * damper)
    assert pushed(surface, floor((0, 0.3, 0)))[1][0, 1] == pytest.approx(STIFFNESS * 0.01 * 0.5 + 0.6 * damper)
    surface.velocity[0] = (0.0, 1e3, 0.0)
    assert not pushed(surface, floor())[1].any()


def test_friction_follows_how_far_points_were_carried_up_to_its_limit():
    surface = Points()
    surface.velocity[:] = (0.02, 0.0, 0.0)
    normal = STIFFNESS * 0.01 * 0.5
    damper = 2.0 * Points.damping * np.sqrt(STIFFNESS * 50.0) * 0.5
    force = pushed(surface, floor(), friction=STICKS)[1]
    assert surface.slip[0] == pytest.approx([0.1 * 0.02, 0, 0])
    assert force[0] == pytest.approx([-STIFFNESS * 0.5 * 0.002 - damper * 0.02, normal, 0])
    force = pushed(surface, floor(), friction=0.1)[1]
    assert force[0] == pytest.approx([-0.1 * normal, normal, 0])
    assert np.linalg.norm(surface.slip[0]) == pytest.approx(0.1 * normal / (STIFFNESS * 0.5))


def test_points_that_know_no_slip_are_dragged_up_to_the_limit():
    surface = Points()
    surface.drag = np.full(3, 200.0)
    surface.velocity[:] = (0.02, 0.0, 0.0)
    normal = STIFFNESS * 0.01 * 0.5
    assert pushed(surface, floor(), friction=0.5)[1][0] == pytest.approx([-200.0 * 0.02, normal, 0])
    surface.velocity[:] = (20.0, 0.0, 0.0)
    assert pushed(surface, floor(), friction=0.5)[1][0] == pytest.approx([-0.5 * normal, normal, 0])
    assert not surface.slip.any()


def test_a_plane_moves_along_its_normal_alone_and_its_work_is_told():
    plane = WallPlane((0.0, 1.0, 0.0), (0.0, 3.0, 0.0), (5.0, 0.5, 0.0))
    plane.go_to(2.0, 0.1)
    assert plane.height(np.array([[9.0, 2.25, 4.0]])) == pytest.approx([0.25])
    plane.go_to(2.0, 0.0)
    assert not plane.velocity.any(), "at rest while time stands still"
    surface = Points()
    contact, force = pushed(surface, floor((3.0, 0.5, 0.0)), friction=0.2)
    assert force[0, 0] > 0.0, "carried along"
    assert contact.external_work() == pytest.approx(0.1 * (3.0 * force[0, 0] + 0.5 * force[0, 1]))


def test_a_normal_may_have_any_length():
    for size in (1e-300, 1.0, 1e300):
        plane = WallPlane((0, 0, 0), (3 * size, 4 * size, 0), (0, 0, 0))
        assert plane.normal == pytest.approx([0.6, 0.8, 0.0], rel=1e-15)
