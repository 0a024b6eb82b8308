"""Patches over which the volume ratio is averaged: which nodes share one, rest and sums, and Cook's membrane."""

import numpy as np
import pytest
from solids import block_of

from pellucid.bodies.meshless_solid.patches import patch_nodes, solid_angles
from pellucid.case import Case
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.geometry.solid_meshes.box import box_mesh
from pellucid.simulation.simulation import Simulation

REFERENCE = 6.959  # validation/meshless-functions: 6.9538 by elements of fourth order, extrapolated from three meshes
KUHN = np.array([(0, 1, 3, 7), (0, 1, 5, 7), (0, 2, 3, 7), (0, 2, 6, 7), (0, 4, 5, 7), (0, 4, 6, 7)])


def test_solid_angles_of_a_cube_are_those_of_its_faces_edges_and_corners():
    mesh = box_mesh(np.zeros(3), np.ones(3), (2, 2, 2))
    angles = np.bincount(mesh.cells.ravel(), solid_angles(mesh).ravel(), len(mesh.nodes)) / (4.0 * np.pi)
    planes = ((mesh.nodes == 0.0) | (mesh.nodes == 1.0)).sum(axis=1)
    assert angles == pytest.approx(0.5**planes, rel=1e-12)


@pytest.mark.parametrize("across", [3, 4])
def test_nodes_of_the_boundary_belong_to_patches_inside(across):
    mesh = box_mesh(np.zeros(3), np.ones(3), (across,) * 3)
    outer = ((mesh.nodes == 0.0) | (mesh.nodes == 1.0)).any(axis=1)
    patch = patch_nodes(mesh)
    assert not outer[patch].any()
    assert patch[~outer] == pytest.approx(np.flatnonzero(~outer))
    assert np.linalg.norm(mesh.nodes[patch] - mesh.nodes, axis=1).max() < 1.001 / across


def membrane(n):
    """Cook's membrane: one layer of cubes, each cut in six."""
    counts = np.array((n, n, 1)) + 1
    number = np.arange(counts.prod()).reshape(counts)
    unit = np.stack(np.meshgrid(*(np.linspace(0, 1, k) for k in counts), indexing="ij"), axis=-1).reshape(-1, 3)
    corner = np.stack([number[i : i + n, j : j + n, k : k + 1].ravel() for k in (0, 1) for j in (0, 1) for i in (0, 1)])
    cells = np.concatenate([corner[list(tetrahedron)].T for tetrahedron in KUHN])
    s, t, w = unit.T
    nodes = np.stack([48 * s, 44 * s + t * (44 - 28 * s), 48 / n * w], axis=1)
    turned = np.linalg.det(nodes[cells[:, 1:]] - nodes[cells[:, :1]]) < 0.0
    cells[turned] = cells[turned][:, [0, 1, 3, 2]]
    return nodes, cells


def test_in_a_single_layer_nodes_of_the_large_faces_have_patches():
    nodes, cells = membrane(4)
    patch = patch_nodes(SimplexMesh(nodes, cells))
    s = nodes[:, 0] / 48
    t = (nodes[:, 1] - 44 * s) / (44 - 28 * s)
    inner = (np.minimum(s, t) > 1e-9) & (np.maximum(s, t) < 1 - 1e-9)
    own = patch == np.arange(len(nodes))
    assert own[inner].all()
    assert not own[~inner & (s < 1.0)].any()
    assert own[~inner].sum() <= 2, "the obtuse corner on the right has no neighbour much further inside"


def test_volumes_of_patches_add_up_and_ratios_are_one_at_rest():
    body = Simulation(Case(schema=1, title="t", time={"end": 1.0}, body=[block_of(cells=(3, 3, 3))]), threads=1).bodies[0]
    solid = body.solid
    assert solid.volume.sum() == pytest.approx(body.mesh.volumes.sum(), rel=1e-12)
    assert (solid.volume_ratio == 1.0).all()
    assert (solid.volume[np.arange(len(solid.patch)) != solid.patch] == 0.0).all()
    assert (solid.volume[solid.patch] > 0.0).all()


def written(path, nodes, cells):
    """Write a Gmsh file of tetrahedra."""
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", str(len(nodes))]
    lines += [f"{k + 1} {x!r} {y!r} {z!r}" for k, (x, y, z) in enumerate(nodes.tolist())]
    lines += ["$EndNodes", "$Elements", str(len(cells))]
    lines += [f"{k + 1} 4 2 1 1 {a} {b} {c} {d}" for k, (a, b, c, d) in enumerate((cells + 1).tolist())]
    path.write_text("\n".join([*lines, "$EndElements", ""]))
    return path


def deflection(tmp_path, n):
    nodes, cells = membrane(n)
    path = written(tmp_path / f"cook-{n}.msh", nodes, cells)
    material = {"kind": "neo-hookean", "density": 1000, "young_modulus": 240.565, "poisson_ratio": 0.4999}
    everywhere = {"box": {"lower": (-1, -1, -1), "upper": (49, 61, 49)}}
    case = Case(
        schema=1,
        title="Cook's membrane",
        time={"end": 1.0},
        steady={},
        body=[{"name": "body", "kind": "meshless-solid", "mesh": {"file": {"path": str(path)}}, "material": material}],
        support=[
            {"body": "body", "where": {"normal": (-1, 0, 0), "within": 5}, "fix": ["x", "y"]},
            {"body": "body", "where": everywhere, "fix": ["z"]},
        ],
        load=[{"kind": "traction", "body": "body", "where": {"normal": (1, 0, 0), "within": 5}, "traction": (0, 6.25, 0)}],
    )
    simulation = Simulation(case, threads=1)
    simulation.step()
    body = simulation.bodies[0]
    tip = np.argmin(np.linalg.norm(nodes - (48, 52, 0), axis=1))
    return body.field("position")[tip, 1] - nodes[tip, 1]


def test_cooks_membrane_is_not_too_stiff_near_incompressibility(tmp_path):
    """With a patch for each node -11.5 and -3.3 %. The singular corner limits the order to one, as for mixed elements."""
    errors = [deflection(tmp_path, n) / REFERENCE - 1.0 for n in (6, 12)]
    assert -0.055 < errors[0] < 0.0
    assert -0.012 < errors[1] < 0.0
    assert np.log2(errors[0] / errors[1]) > 1.0
