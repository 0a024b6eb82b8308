"""Contact between surfaces of triangles, and of one with itself: forces, sides, images."""

from math import inf

import numpy as np
import pytest
from triangle_surfaces import FreeTriangles, square, step

from pellucid.contact.images import Plane, Seam
from pellucid.contact.overlap import OUT
from pellucid.contact.surface_pairs import SurfacePairs
from pellucid.contact.triangles.pair import TrianglePair
from pellucid.contact.triangles.slots import APART


def bumpy(n, height, seed, thickness, size=1.0):
    """A sheet whose vertices are off a plane by up to half of its edges, along and across."""
    vertices, triangles = square(n, size, height)
    vertices += np.random.default_rng(seed).uniform(-0.2, 0.2, vertices.shape) * size / n
    return FreeTriangles(vertices, triangles, thickness)


INSTANT = 1e-9  # s: so short that the motion within it does not change the overlap


def energy(pair):
    step(pair, INSTANT)
    return pair.law.held.stored


def assert_slope(pair, surfaces, moved=1e-7):
    """The forces are the slopes of the energy: against differences of second order; a third of the vertices, every axis."""
    assert step(pair, INSTANT)
    forces = [surface.force.copy() for surface in surfaces]
    scale = max(np.abs(force).max() for force in forces)
    checked = 0
    for surface, force in zip(surfaces, forces, strict=True):
        for i in range(0, len(surface.vertices), 3):
            for d in range(3):
                x = surface.vertices[i, d]
                surface.vertices[i, d] = x + moved
                above = energy(pair)
                surface.vertices[i, d] = x - moved
                below = energy(pair)
                surface.vertices[i, d] = x
                assert -(above - below) / (2.0 * moved) == pytest.approx(force[i, d], abs=1e-5 * scale)
                checked += force[i, d] != 0.0
    assert checked > 20
    total = sum(force.sum(axis=0) for force in forces)
    torque = sum(np.cross(s.vertices, force).sum(axis=0) for s, force in zip(surfaces, forces, strict=True))
    assert max(np.abs(total).max(), np.abs(torque).max()) < 1e-12 * scale * len(forces[0])


def approach(pair, upper, way, steps=20):
    """Lower a surface in small steps, so that it comes into sight before it touches."""
    step(pair)
    for _ in range(steps):
        upper.vertices[:, 2] -= way / steps
        upper.speeds[:] = (0.0, 0.0, -way / steps / 1e-5)
        step(pair)
    upper.speeds[:] = 0.0
    step(pair)


def test_forces_between_sheets_are_slopes_of_the_energy():
    lower, upper = bumpy(5, 0.0, 1, 0.12), bumpy(4, 0.4, 2, 0.08, 0.83)
    pair = TrianglePair(lower, upper, 0.0, 0.5)
    approach(pair, upper, 0.32)
    assert_slope(pair, (lower, upper))


def test_forces_between_solids_are_slopes_of_the_energy():
    lower, upper = bumpy(5, 0.0, 3, 0.0), bumpy(4, 0.2, 4, 0.0, 0.83)
    upper.triangles = upper.triangles._replace(triangles=upper.triangles.triangles[:, ::-1].copy())
    pair = TrianglePair(lower, upper, 0.0, 0.5)
    approach(pair, upper, 0.22)
    assert_slope(pair, (lower, upper))


def folded(n=12, gap=0.2, radius=0.1, thickness=0.1):
    """A sheet that is folded in two about y: half a cylinder joins two flat halves."""
    vertices, triangles = square(n)
    s = vertices[:, 0] * 2.4 - 1.2
    bend = np.pi * radius
    angle = np.clip(s / bend + 0.5, 0.0, 1.0) * np.pi
    x = radius * np.sin(angle) - np.maximum(np.abs(s) - 0.5 * bend, 0.0)
    z = -radius * np.cos(angle)
    return FreeTriangles(np.column_stack([x, vertices[:, 1], z]), triangles, thickness)


def test_a_fold_touches_itself_by_slopes_of_the_energy():
    sheet = folded()
    pair = TrianglePair(sheet, sheet, 0.0, 0.5)
    step(pair)
    rng = np.random.default_rng(5)
    for _ in range(20):  # the halves come nearer, each more at its rim
        flat = np.clip(-sheet.vertices[:, 0], 0.0, None)
        sheet.speeds[:] = 0.0
        sheet.speeds[:, 2] = -np.sign(sheet.vertices[:, 2]) * flat * 350.0
        sheet.vertices += sheet.speeds * 1e-5
        step(pair)
    sheet.vertices += rng.uniform(-0.003, 0.003, sheet.vertices.shape)
    sheet.speeds[:] = 0.0
    assert_slope(pair, (sheet,))


def test_a_flat_sheet_does_not_touch_itself():
    for thickness in (0.01, 0.3):
        sheet = FreeTriangles(*square(8), thickness)
        pair = TrianglePair(sheet, sheet, 0.0, 0.5)
        assert not step(pair)


def test_parts_nearer_along_the_sheet_than_it_is_thick_do_not_touch_each_other():
    """Elements much shorter than the thickness buckle into a zigzag; most elements of the sheet are longer."""
    vertices, triangles = square(18)
    column = np.rint(vertices[:, 0] * 18).astype(int)
    vertices[:, 0] = np.concatenate([[0.0], np.cumsum(np.where(np.abs(np.arange(18) - 8.5) < 6.0, 0.01, 0.2))])[column]
    sheet = FreeTriangles(vertices, triangles, 0.06)
    pair = TrianglePair(sheet, sheet, 0.0, 0.5)
    assert not step(pair)
    flat, inside = sheet.vertices.copy(), np.clip(column - 3, 0, 12)
    up = np.where(np.arange(12) // 3 % 2, -1.0, 1.0)  # three elements up and three down
    height = np.concatenate([[0.0], np.cumsum(0.01 * up)])[inside]
    for angle in np.linspace(0.0, np.pi / 3.0, 30):
        before = sheet.vertices.copy()
        sheet.vertices[:, 0] = flat[:, 0] - 0.01 * inside * (1.0 - np.cos(angle))
        sheet.vertices[:, 2] = height * np.sin(angle)
        sheet.speeds[:] = (sheet.vertices - before) / 1e-5
        assert not step(pair)


def test_sheets_keep_their_side():
    """One that was pushed through by less than the thickness is pushed back to where it came from, from either side."""
    for sign in (1.0, -1.0):
        lower, upper = FreeTriangles(*square(6), 0.05), FreeTriangles(*square(4, 0.5, 0.3 * sign), 0.05)
        upper.vertices[:, :2] += 0.21
        pair = TrianglePair(lower, upper, 0.0, 0.5)
        step(pair)
        for _ in range(32):
            upper.vertices[:, 2] -= sign * 0.01
            upper.speeds[:, 2] = -sign * 0.01 / 1e-5
            step(pair)
        upper.speeds[:] = 0.0
        assert step(pair)
        assert sign * upper.vertices[0, 2] == pytest.approx(-0.02)
        assert sign * upper.force[:, 2].sum() > 0.0
        assert upper.force[:, 2].sum() == pytest.approx(-lower.force[:, 2].sum())


def test_the_force_is_the_pressure_on_the_area():
    """k d A, but for the points beside the rim, which the round rim pushes a little: less than 2 % here."""
    lower, upper = FreeTriangles(*square(40), 0.01), FreeTriangles(*square(10, 0.5, 0.012), 0.01)
    upper.vertices[:, :2] += 0.24375  # so that the points of the lower sheet lie a quarter of an edge off the rim
    pair = TrianglePair(lower, upper, 0.0, 0.5)
    approach(pair, upper, 0.004)
    step(pair, INSTANT)
    found = [overlap for side in pair.sides if (overlap := side.find(INSTANT)) is not None]
    stiffness = sum(pair.law.normal_stiffness(overlap)[0] / overlap.area[0] for overlap in found)
    assert upper.force[:, 2].sum() == pytest.approx(stiffness * 0.002 * 0.25, rel=0.02)


def test_a_point_passes_around_the_rim_and_touches_the_other_side():
    lower, ball = FreeTriangles(*square(6), 0.05), FreeTriangles(*square(1, 0.1, 0.1), 0.05)
    pair = TrianglePair(lower, ball, 0.0, 0.5)
    ball.vertices[:, :2] += 0.45
    way = [(0.0, 0.0, -0.06), (0.65, 0.0, 0.0), (0.0, 0.0, -0.1), (-0.65, 0.0, 0.0), (0.0, 0.0, 0.03)]
    pushed = []
    for part in way:
        for _ in range(50):
            ball.vertices += np.array(part) / 50
            ball.speeds[:] = np.array(part) / 50 / 1e-5
            step(pair)
        ball.speeds[:] = 0.0
        step(pair)
        pushed.append(np.sign(np.round(ball.force[:, 2].sum(), 9)))
    assert pushed == [1.0, 0.0, 0.0, 0.0, -1.0]


def test_images_at_a_plane_of_symmetry_push_as_the_other_half_does():
    """A fold of which half is computed, symmetric to z = 0: its own image is as good as the other half."""
    whole = folded()
    upper = whole.vertices[:, 2] > -1e-9
    keep = upper[whole.triangles.triangles].all(axis=1)
    number = np.cumsum(upper) - 1
    half = FreeTriangles(whole.vertices[upper], number[whole.triangles.triangles[keep]], whole.half_width * 2.0)
    pairs = TrianglePair(whole, whole, 0.0, 0.5), TrianglePair(half, half, 0.0, 0.5, planes=[Plane(2, 0.0)])
    for pair in pairs:
        step(pair)
    for _ in range(20):
        for surface in (whole, half):
            flat = np.clip(-surface.vertices[:, 0], 0.0, None)
            surface.speeds[:] = 0.0
            surface.speeds[:, 2] = -np.sign(surface.vertices[:, 2]) * flat * 350.0
            surface.vertices += surface.speeds * 1e-5
        touches = [step(pair) for pair in pairs]
        assert touches[0] == touches[1]
    assert touches[0]
    assert half.force == pytest.approx(whole.force[upper], abs=1e-9 * np.abs(whole.force).max())
    assert pairs[1].law.held.stored == pytest.approx(0.5 * pairs[0].law.held.stored)


def test_sheets_touch_across_the_seam_of_a_periodic_grid():
    lower, upper = FreeTriangles(*square(6), 0.05), FreeTriangles(*square(4, 0.5, 0.06), 0.05)
    far = FreeTriangles(upper.vertices + np.array((0.9, 0.3, 0.0)), upper.triangles.triangles, 0.05)
    near = FreeTriangles(upper.vertices + np.array((-0.1, 0.3, 0.0)), upper.triangles.triangles, 0.05)
    forces = []
    for surface in (far, near):
        pair = TrianglePair(lower, surface, 0.0, 0.5, seams=[Seam(0, 0.0, 1.0)])
        approach(pair, surface, 0.02)
        forces.append((surface.force.copy(), lower.force.copy()))
    for one, other in zip(*forces, strict=True):
        assert one == pytest.approx(other, abs=1e-9 * np.abs(other).max())
    assert forces[0][0][:, 2].sum() > 0.0


def test_a_flat_sheet_that_goes_on_in_images_does_not_touch_them():
    sheet = FreeTriangles(*square(6), 0.2)
    for planes, seams in (([Plane(0, 0.0), Plane(1, 0.0), Plane(1, 1.0)], []), ([], [Seam(0, 0.0, 1.0), Seam(1, 0.0, 1.0)])):
        assert not step(TrianglePair(sheet, sheet, 0.0, 0.5, planes=planes, seams=seams))


def test_the_overlap_of_the_start_is_one_depth_for_all_points():
    """A sheet that leans, by 0.04 within the thickness of another: it presses as far as it comes nearer, until it was apart."""
    lower, upper = FreeTriangles(*square(6), 0.1), FreeTriangles(*square(4, 0.5, 0.06), 0.1)
    upper.vertices += np.array((0.21, 0.23, 0.0))
    upper.vertices[:, 2] += 0.04 * (upper.vertices[:, 0] - 0.21)
    pair = TrianglePair(lower, upper, 0.0, 0.5)

    def deepest(side):
        return float(side.slots.depth[side.slots.state != APART].max(initial=0.0))

    assert not step(pair)
    # points of the lower sheet meet the leaning one beside its lowest edge
    assert [side.start.depth for side in pair.sides] == pytest.approx([0.038, 0.04], abs=3e-3)
    assert pair.start_depth() == pytest.approx(0.04)
    approach(pair, upper, 0.01)
    assert deepest(pair.sides[1]) == pytest.approx(0.01)
    assert pair.start_depth() == pytest.approx(0.04)
    for left in (0.02, 0.0):
        approach(pair, upper, -0.03)
        for _ in range(OUT):
            step(pair)
        assert pair.start_depth() == pytest.approx(left)
    approach(pair, upper, 0.05)
    assert deepest(pair.sides[1]) == pytest.approx(0.04), "where it was at the start, it presses now"


def test_the_overlap_of_a_fold_at_the_start_is_reported():
    sheet = folded()
    pair = TrianglePair(sheet, sheet, 0.0, 0.5)
    step(pair)
    assert pair.start_overlaps() == []
    assert pair.distance == 2.0 * sheet.half_width
    assert pair.start_depth() == max(float(side.slots.born.max()) for side in pair.sides)


def test_a_fold_within_an_element_is_warned_of():
    """A square is folded about its middle line by a given angle; edges of the shape at the start do not count."""
    vertices, triangles = square(2)
    x = vertices[:, 0].copy()

    def fold(degrees):
        angle, beyond = np.radians(degrees), np.maximum(x - 0.5, 0.0)
        return np.column_stack([np.minimum(x, 0.5) + beyond * np.cos(angle), vertices[:, 1], beyond * np.sin(angle)])

    sheet = FreeTriangles(vertices, triangles, 0.02)
    pair = TrianglePair(sheet, sheet, 0.0, 0.4)
    for degrees, warned in ((0.0, False), (120.0, False), (150.0, True)):
        sheet.vertices[:] = fold(degrees)
        step(pair)
        text = pair.warning()
        assert (text is not None) == warned
        assert text is None or f"is folded by {degrees:.0f} degrees between two neighbouring elements" in text
    begun = FreeTriangles(fold(150.0), triangles, 0.02)
    assert TrianglePair(begun, begun, 0.0, 0.4).warning() is None
    assert text in SurfacePairs([pair]).warnings(inf).values()
