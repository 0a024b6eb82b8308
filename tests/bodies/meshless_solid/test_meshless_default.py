"""The functions that meshless solids have by default: on meshes of all closed surfaces, in bending, on prescribed faces."""

import numpy as np
import pytest
from closed_surfaces import CLOSED, red_cell

from pellucid.approximants.nodal.table import evaluate, face_shares
from pellucid.bodies.meshless_solid.functions import quadrature_places
from pellucid.bodies.meshless_solid.model import MeshlessSolidCase
from pellucid.bodies.meshless_solid.prescribed import values_at_nodes
from pellucid.case import Case
from pellucid.geometry.surfaces.surface import Surface
from pellucid.simulation.simulation import Simulation

RUBBER = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 1e4, "poisson_ratio": 0.3}


def mesh_of(table):
    return MeshlessSolidCase(name="body", mesh=table, material=RUBBER).mesh_in_order()


def check_functions_everywhere(mesh):
    """At quadrature points with gradients, at the nodes, and on the faces: they add up to one and reproduce places."""
    evaluator = MeshlessSolidCase.model_fields["approximant"].default.evaluator(mesh)
    places = quadrature_places(mesh, 4)
    rows = evaluate(evaluator, np.repeat(np.arange(len(mesh.cells)), 4), places)
    extent = np.ptp(mesh.nodes, axis=0).max()
    for k in range(0, len(places), 41):
        nodes, values, slopes = rows.at(k)
        assert values.sum() == pytest.approx(1.0, abs=1e-12)
        # quadratic moments may be regular by the penalty of 1e-7 alone, which costs that many digits
        assert values @ mesh.nodes[nodes] == pytest.approx(places[k], abs=1e-9 * extent)
        assert slopes @ mesh.nodes[nodes] == pytest.approx(np.eye(3), abs=1e-7)
    assert values_at_nodes(mesh, evaluator).sum(axis=1) == pytest.approx(1.0, abs=1e-12)
    faces, owners = mesh.faces
    outer = mesh.boundary
    shares = face_shares(evaluator, mesh.nodes, faces[outer], owners[outer, 0])
    assert shares.at_nodes(np.ones((len(outer), 3)), len(mesh.nodes)).sum() == pytest.approx(3 * len(outer), rel=1e-12)


@pytest.mark.parametrize("name", CLOSED)
def test_closed_surfaces_run_by_default(name):
    pytest.importorskip("tetgen")
    surface = {name: CLOSED[name]}
    extent = float(np.ptp(Surface(**surface).triangulate().vertices, axis=0).max())
    check_functions_everywhere(mesh_of({"inside": {"surface": surface, "size": extent / 5}}))
    check_functions_everywhere(mesh_of({"fill": {"shape": {"inside": {"surface": surface}}, "size": extent / 12}}))


def test_a_biconcave_surface_of_a_file_runs_by_default(tmp_path):
    pytest.importorskip("tetgen")
    cell, path = red_cell(3), tmp_path / "cell.obj"
    lines = [f"v {x:.7g} {y:.7g} {z:.7g}" for x, y, z in cell.vertices]
    path.write_text("\n".join([*lines, *(f"f {a} {b} {c}" for a, b, c in cell.triangles + 1), ""]))
    surface = {"file": {"path": str(path), "closed": True, "unit": "um"}}
    check_functions_everywhere(mesh_of({"inside": {"surface": surface, "size": 1e-6}}))
    check_functions_everywhere(mesh_of({"fill": {"shape": {"inside": {"surface": surface}}, "size": 0.6e-6}}))


def test_quadratic_fields_are_reproduced():
    """But for what the penalty of 1e-7 on quadratic coefficients takes from them."""
    mesh = mesh_of({"box": {"lower": (0, 0, 0), "upper": (1, 1, 1), "cells": (3, 3, 3)}})
    evaluator = MeshlessSolidCase.model_fields["approximant"].default.evaluator(mesh)
    places = quadrature_places(mesh, 4)
    rows = evaluate(evaluator, np.repeat(np.arange(len(mesh.cells)), 4), places, gradients=False)
    square = mesh.nodes[:, 0] * mesh.nodes[:, 2] - 2.0 * mesh.nodes[:, 1] ** 2
    found = np.array([values @ square[nodes] for nodes, values, _ in map(rows.at, range(len(places)))])
    assert found == pytest.approx(places[:, 0] * places[:, 2] - 2.0 * places[:, 1] ** 2, abs=1e-4)


def test_a_lone_prescribed_node_is_warned_of():
    """Others have a part in the material there."""
    mesh = {"box": {"lower": (0, 0, 0), "upper": (1, 1, 1), "cells": (2, 2, 2)}}
    body = {"name": "block", "kind": "meshless-solid", "mesh": mesh, "material": RUBBER}
    foot, pin = {"where": {"normal": (0, 0, -1)}}, {"where": {"box": {"lower": (0.4, 0.4, 0.9), "upper": (0.6, 0.6, 1.1)}}}
    table = {"schema": 1, "title": "a test", "time": {"end": 1.0}, "body": [body], "support": [foot, pin | {"body": "block"}]}
    with pytest.warns(UserWarning, match=r"select 1 of its nodes that do not form a whole face.*sebciem"):
        Simulation(Case.model_validate(table), threads=1)


def test_a_cantilever_of_two_cells_across_bends():
    """P L²/(E I) = 2: finite elements of second order have 0.4974 L at the tip, the elastica 0.4935
    (validation/meshless-functions). A mesh of two cells across leaves errors of (h/L)² = 0.0025."""
    mesh = {"box": {"lower": (0, 0, 0), "upper": (1, 0.1, 0.1), "cells": (20, 2, 2)}}
    material = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 1.2e6, "poisson_ratio": 0.0}
    load = {"kind": "traction", "body": "beam", "where": {"normal": (1, 0, 0)}, "traction": (0, 0, -2000), "rise": 1.0}
    table = {"schema": 1, "title": "a test", "time": {"end": 1.0}, "steady": {"tolerance": 1e-4}, "load": [load]}
    body = {"name": "beam", "kind": "meshless-solid", "mesh": mesh, "material": material}
    foot = {"body": "beam", "where": {"normal": (-1, 0, 0)}}
    simulation = Simulation(Case.model_validate(table | {"body": [body], "support": [foot]}), threads=1)
    while not simulation.clock.finished(None):
        simulation.step()
    beam = simulation.bodies[0]
    tip = np.flatnonzero(np.abs(beam.mesh.nodes - (1, 0.05, 0.05)).max(axis=1) < 1e-9)
    assert beam.field("position")[tip, 2] - 0.05 == pytest.approx(-0.4974, rel=0.0025)
    assert max(beam.facts().values()) < 1e-12
