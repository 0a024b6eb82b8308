"""Elements that make the stable step of a mesh small: few are found, what is graded or bad all over is not."""

import numpy as np
import pytest

from pellucid.case import Case
from pellucid.geometry.checks.quality import slowest_of_solid, slowest_of_surface
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.geometry.meshes.surface_mesh import NO_QUADS, NO_TRIANGLES, Mesh, grid_quads
from pellucid.geometry.solid_meshes.box import BoxMesh
from pellucid.simulation.simulation import Simulation


def squares(n):
    """A sheet of n × n quadrilaterals of 1 m², and the number of the one in its middle."""
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0), indexing="ij")
    vertices = np.column_stack([x.ravel(), y.ravel(), np.zeros((n + 1) ** 2)])
    return Mesh(vertices, grid_quads(n + 1, n + 1, False), NO_TRIANGLES), (n // 2) * n + n // 2


def with_a_short_edge(mesh, element, length):
    """The second corner of an element moved to this distance from its first."""
    one, other = mesh.quads[element, :2]
    vertices = mesh.vertices.copy()
    vertices[other] = vertices[one] + length * (vertices[other] - vertices[one])
    return mesh._replace(vertices=vertices)


def triangles(mesh):
    return Mesh(*mesh.triangulated()[:1], NO_QUADS, mesh.triangulated().triangles)


def membrane(path):
    return {
        "name": "sheet",
        "kind": "membrane-elements",
        "surface": {"file": {"path": str(path), "closed": False}},
        "thickness": 0.01,
        "material": {"kind": "linear-membrane", "density": 1000.0, "young_modulus": 1e4, "poisson_ratio": 0.3},
    }


def written(mesh, path):
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist()]
    lines += ["f " + " ".join(str(node + 1) for node in face) for face in [*mesh.quads.tolist(), *mesh.triangles.tolist()]]
    path.write_text("\n".join(lines) + "\n")
    return path


def simulation(body):
    return Simulation(Case.model_validate({"schema": 1, "title": "a test", "time": {"end": 1.0}, "body": [body]}), threads=1)


def test_even_surfaces_have_none():
    mesh, _ = squares(16)
    assert slowest_of_surface(mesh) is None
    assert slowest_of_surface(triangles(mesh)) is None


def test_triangles_beside_a_short_edge_are_found():
    mesh, middle = squares(16)
    found = slowest_of_surface(triangles(with_a_short_edge(mesh, middle, 0.02)))
    assert found is not None
    assert found.times > 5.0
    assert len(found.elements) <= 5


def test_what_is_fine_all_over_or_by_more_than_one_in_a_hundred_is_not():
    mesh, _ = squares(16)
    thin = mesh._replace(vertices=mesh.vertices * [1.0, 0.01, 1.0])
    assert slowest_of_surface(thin) is None
    row = mesh.vertices.copy()
    row[row[:, 1] > 0.5, 1] -= 0.95  # one row in sixteen
    assert slowest_of_surface(mesh._replace(vertices=row)) is None


def test_a_membrane_warns_of_the_step_that_it_would_have(tmp_path):
    mesh, middle = squares(16)
    good, bad = triangles(mesh), triangles(with_a_short_edge(mesh, middle, 0.02))
    even = simulation(membrane(written(good, tmp_path / "good.obj"))).bodies[0].totals.rate
    with pytest.warns(
        UserWarning, match=r"stable time step of body sheet is .* times smaller than without .* at \(8.* improve the mesh"
    ):
        body = simulation(membrane(written(bad, tmp_path / "bad.obj"))).bodies[0]
    found = slowest_of_surface(bad)
    left = np.delete(bad.triangles, found.elements, axis=0)
    rest = simulation(
        membrane(written(Mesh(bad.vertices[np.unique(left)], NO_QUADS, _renumbered(left)), tmp_path / "rest.obj"))
    )
    assert body.totals.rate / rest.bodies[0].totals.rate == pytest.approx(found.times, rel=0.01)
    assert rest.bodies[0].totals.rate < 6.0 * even


def _renumbered(cells):
    return np.unique(cells, return_inverse=True)[1].reshape(cells.shape)


def block(nearness):
    """A cube of 6³ boxes, a node in the middle of which is moved to one of its neighbours up to this part of the way."""
    mesh = BoxMesh(lower=(0, 0, 0), upper=(1, 1, 1), cells=(6, 6, 6)).mesh()
    nodes = mesh.nodes.copy()
    middle = int(np.argmin(np.linalg.norm(nodes - 0.5, axis=1)))
    cell = mesh.cells[(mesh.cells == middle).any(axis=1)][0]
    neighbour = cell[cell != middle][0]
    nodes[middle] = nodes[neighbour] + nearness * (nodes[middle] - nodes[neighbour])
    return SimplexMesh(nodes, mesh.cells)


def solid(mesh, path, kind):
    lines = ["*NODE", *(f"{n + 1}, {x!r}, {y!r}, {z!r}" for n, (x, y, z) in enumerate(mesh.nodes.tolist()))]
    lines += ["*ELEMENT, TYPE=C3D4, ELSET=all"]
    lines += [f"{n + 1}, " + ", ".join(str(node + 1) for node in cell) for n, cell in enumerate(mesh.cells.tolist())]
    path.write_text("\n".join(lines) + "\n")
    return {
        "name": "block",
        "kind": "meshless-solid",
        "mesh": {"file": {"path": str(path)}},
        "approximant": {"kind": kind},
        "material": {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 1e4, "poisson_ratio": 0.3},
    }


@pytest.mark.parametrize("nearness", [1.0, 0.1])
def test_tetrahedra_that_make_no_step_five_times_smaller_are_not_told(nearness):
    assert slowest_of_solid(block(nearness)) is None


def test_a_solid_with_linear_functions_warns_of_the_step_that_it_would_have(tmp_path):
    even = simulation(solid(block(1.0), tmp_path / "even.inp", "linear-simplex")).bodies[0].totals.rate
    with pytest.warns(UserWarning, match="stable time step of body block is .* times smaller than without"):
        body = simulation(solid(block(0.003), tmp_path / "bad.inp", "linear-simplex")).bodies[0]
    assert slowest_of_solid(block(0.003)).times == pytest.approx(body.totals.rate / even, rel=0.2)


def test_functions_that_reach_beyond_their_cells_keep_their_step(tmp_path, recwarn):
    rates = [
        simulation(solid(block(t), tmp_path / "b.inp", "cell-based-maximum-entropy")).bodies[0].totals.rate for t in (1, 0.003)
    ]
    assert rates[1] == pytest.approx(rates[0], rel=0.01)
    assert not [warning for warning in recwarn if "the stable time step of body" in str(warning.message)]
