"""The heart of two ventricles: its volume against integrals over the ellipsoids, its sets, its walls."""

import re
from functools import cache

import numpy as np
import pytest
from boundaries import boundary_edges
from pydantic import ValidationError

from pellucid.geometry.checks.quality import dihedral_angles
from pellucid.geometry.checks.solid_checks import solid_faults
from pellucid.geometry.solid_meshes.solid_mesh import SolidMesh

SIZES = (0.002, 0.0015, 0.001)


def width(x, z, semi_axes, offset=0.0):
    """Half the width along y of an ellipsoid [m]."""
    a, b, c = semi_axes
    return b * np.sqrt(np.maximum(0.0, 1.0 - ((x - offset) / a) ** 2 - (z / c) ** 2))


@cache
def volume():
    """Of the walls [m³], by the midpoint rule over x and z; all is symmetric about y = 0."""
    x, z = (start + step * (np.arange(n) + 0.5) for start, step, n in ((-0.03, 2e-5, 4000), (-0.05, 2e-5, 3000)))
    x, z = np.meshgrid(x, z)
    left, left_outer = width(x, z, (0.022, 0.022, 0.045)), width(x, z, (0.027, 0.027, 0.050))
    right, right_outer = width(x, z, (0.032, 0.023, 0.043), 0.010), width(x, z, (0.036, 0.027, 0.047), 0.010)
    across = np.maximum(left_outer, right_outer) - left - np.maximum(right - left_outer, 0.0)
    return 2.0 * float(across.sum()) * (2e-5) ** 2


@cache
def heart(size):
    return SolidMesh(heart={"size": size}).mesh()


@pytest.mark.parametrize("size", SIZES[:2])
def test_it_is_sound_well_shaped_and_closed(size):
    mesh = heart(size)
    assert list(solid_faults(mesh)) == []
    angles = dihedral_angles(mesh.nodes, mesh.cells)
    assert angles.min() > 10.7  # what Labelle & Shewchuk 2007 guarantee on the same lattice
    assert angles.max() < 164.8
    assert set(boundary_edges(mesh)) == {2}


def test_its_volume_is_that_between_the_ellipsoids():
    errors = np.array([abs(heart(size).volumes.sum() / volume() - 1.0) for size in SIZES[:2]])
    assert errors[0] < 0.004
    # round walls err with the square of the size; notches where the ventricles meet are blunt by a cell or less
    assert np.log(errors[0] / errors[1]) / np.log(SIZES[0] / SIZES[1]) > 1.5


def test_sets_lie_where_their_names_say():
    mesh = heart(SIZES[0])
    at = {name: mesh.nodes[numbers] for name, numbers in mesh.sets.items()}

    def level(points, semi_axes, offset=0.0):
        return np.sum(((points - (offset, 0.0, 0.0)) / semi_axes) ** 2, axis=1)

    assert set(at) == {"base", "apex", "epi", "lv-endo", "rv-endo", "rv-patch"}
    assert all(len(points) > 100 for points in at.values())
    assert at["base"][:, 2] == pytest.approx(0.010, abs=1e-12)
    assert level(at["lv-endo"], (0.022, 0.022, 0.045)) == pytest.approx(1.0, abs=1e-8)
    left, right = level(at["epi"], (0.027, 0.027, 0.050)), level(at["epi"], (0.036, 0.027, 0.047), 0.010)
    assert np.minimum(left, right) == pytest.approx(1.0, abs=1e-8)
    septum, wall = level(at["rv-endo"], (0.027, 0.027, 0.050)), level(at["rv-endo"], (0.032, 0.023, 0.043), 0.010)
    assert np.minimum(abs(septum - 1.0), abs(wall - 1.0)) == pytest.approx(0.0, abs=1e-8)
    assert at["apex"][:, 2].max() <= -0.045 + 1e-12
    assert at["apex"][:, 2].min() == pytest.approx(-0.050, abs=2e-4)
    middle = at["rv-patch"].mean(axis=0)
    assert middle[0] > 0.040, "towards +x, on the right ventricle"
    across = np.ptp(at["rv-patch"], axis=0)[1:]
    assert (across <= 0.020).all()
    assert (across >= 0.020 - 2 * SIZES[0]).all(), "nodes are about an edge apart"
    sides = set(mesh.sets["epi"]) | set(mesh.sets["lv-endo"]) | set(mesh.sets["rv-endo"]) | set(mesh.sets["base"])
    assert sides == set(np.unique(mesh.faces[0][mesh.boundary])), "every outer node is in a set"


@pytest.mark.slow
@pytest.mark.timeout(0)
def test_three_edges_or_more_lead_through_the_right_wall_at_the_finest():
    mesh = heart(SIZES[2])
    away = np.full(len(mesh.nodes), -1)
    front, links = mesh.sets["epi"], mesh.neighbours
    for distance in range(8):
        away[front] = distance
        near = np.zeros(len(away), bool)
        near[np.concatenate([links.indices[links.indptr[a] : links.indptr[a + 1]] for a in front])] = True
        front = np.flatnonzero(near & (away < 0))
    inner = mesh.nodes[mesh.sets["rv-endo"]]
    free = np.abs(np.sum(((inner - (0.010, 0, 0)) / (0.032, 0.023, 0.043)) ** 2, axis=1) - 1.0) < 1e-8
    assert away[mesh.sets["rv-endo"][free]].min() == 3


def test_walls_that_the_lattice_would_miss_are_refused():
    with pytest.raises(ValidationError, match=r"heart.size\n.*less than or equal to 0.0035"):
        SolidMesh(heart={"size": 0.004})
    with pytest.raises(
        ValidationError, match=r"the mesh would have about 7.6e.07 points, but at most 2e.06 are allowed; make the mesh coarser"
    ):
        SolidMesh(heart={"size": 0.0002})


@pytest.mark.parametrize(("key", "name"), [("patch_radius", "rv-patch"), ("apex_height", "apex")])
def test_a_part_that_no_node_is_in_names_its_key_and_what_is_enough(key, name):
    with pytest.raises(
        ValidationError, match=f"`{key}` = 1e-05 m is too small: no outer node lies within it, so set {name}"
    ) as error:
        SolidMesh(heart={"size": 0.0035, key: 1e-5})
    enough = float(re.search(rf"set `{key}` to at least (\S+) m", str(error.value)).group(1))
    sets = SolidMesh(heart={"size": 0.0035, key: enough}).mesh().sets
    assert 0 < len(sets[name]) < 5
