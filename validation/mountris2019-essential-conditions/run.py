"""Essential conditions of meshless solids: what the field lacks of what is prescribed, and what the remedies cost.

Writes faces.csv (maximum entropy on a patch, half a face and a re-entrant face, plain and with supports bounded there) and
pull.csv (a cube between clamps, by approximant and by how its conditions are imposed) beside this script.
"""

import csv
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from pellucid.approximants.nodal.maximum_entropy import CellMaximumEntropyModel
from pellucid.bodies.meshless_solid.prescribed import PrescribedField, values_at_nodes
from pellucid.case import Case
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.geometry.solid_meshes.box import box_mesh
from pellucid.simulation.simulation import Simulation

HERE = Path(__file__).parent
EDGE, PULL = 0.1, 0.05  # of the cube, and by how much its clamps move apart [m]
TISSUE = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 3e3, "poisson_ratio": 0.49}
UNITS = ["step_s", "steps", "strain_energy_J", "reaction_z_N", "residual_nodes_m", "residual_between_m"]
WAYS = [("cell-based-maximum-entropy", "direct"), ("linear-simplex", "direct")]
WAYS += [(f"{kind}moving-least-squares", how) for kind in ("", "modified-") for how in ("sebciem", "ebciem")]


def l_mesh(n: int) -> SimplexMesh:
    """The box of edges 2, 2 and 1 without its quarter where x and y are above 1, from boxes that share their faces."""
    parts = [box_mesh(np.array((x, y, 0.0)), np.array((x + 1.0, y + 1.0, 1.0)), (n, n, n)) for x, y in ((0, 0), (1, 0), (0, 1))]
    places = np.concatenate([part.nodes for part in parts])
    _, first, which = np.unique(np.round(places * 4 * n).astype(int), axis=0, return_index=True, return_inverse=True)
    shift = np.cumsum([0, *(len(part.nodes) for part in parts[:-1])])
    cells = np.concatenate([part.cells + start for part, start in zip(parts, shift, strict=True)])
    return SimplexMesh(places[first], which.ravel()[cells])


def faces() -> Iterator[list[object]]:
    regions: list[tuple[str, Callable[[int], SimplexMesh], Callable[[np.ndarray], np.ndarray]]] = [
        ("whole face", lambda n: box_mesh(np.zeros(3), np.ones(3), (n, n, n)), lambda x: x[:, 2] > 1.0 - 1e-9),
        ("patch", lambda n: box_mesh(np.zeros(3), np.ones(3), (n, n, n)), in_patch),
        ("re-entrant", l_mesh, inwards),
    ]
    yield ["region", "nodes", "faces", "bounding", "plain_nodes", "plain_between", "bounded_nodes", "bounded_between"]
    for name, mesh_of, where in regions:
        for n in (4, 6, 8):
            mesh = mesh_of(n)
            on_surface = np.isin(np.arange(len(mesh.nodes)), mesh.faces[0][mesh.boundary])
            number = np.tile((where(mesh.nodes) & on_surface)[:, None], 3).astype(np.int64)
            field = PrescribedField(mesh, number, number, 1)
            field.displacement[:] = 1.0
            plain = CellMaximumEntropyModel().evaluator(mesh)
            disturbed = field.disturbed_faces(plain)
            bounded = CellMaximumEntropyModel().vanishing(plain, mesh, disturbed)
            found = [
                field.residuals(values_at_nodes(mesh, evaluator), evaluator).largest(number.astype(float))
                for evaluator in (plain, bounded)
            ]
            numbers = [f"{one[key]:.2g}" for one in found for key in ("nodes", "between")]
            yield [name, len(mesh.nodes), len(field.faces), len(disturbed), *numbers]


def in_patch(x: np.ndarray) -> np.ndarray:
    return np.asarray((x[:, 2] > 1.0 - 1e-9) & (abs(x[:, :2] - 0.5) < 0.26).all(axis=1))


def inwards(x: np.ndarray) -> np.ndarray:
    one = (abs(x[:, 0] - 1.0) < 1e-9) & (x[:, 1] > 1.0 - 1e-9)
    other = (abs(x[:, 1] - 1.0) < 1e-9) & (x[:, 0] > 1.0 - 1e-9)
    return np.asarray(one | other)


def pulls() -> Iterator[list[object]]:
    yield ["approximant", "essential", "nodes", *UNITS]
    for n in (3, 5, 8):
        for kind, how in WAYS:
            simulation = Simulation(Case.model_validate(cube(n, kind, how)))
            while not simulation.clock.finished(None):
                simulation.step()
            body, energy = simulation.bodies[0], simulation.budget.energies()["strain"]
            facts = [f"{body.facts()[f'ebc_residual_{name}']:.2g}" for name in ("nodes", "between")]
            reaction = simulation.budget.reactions()["top"][2]  # an impulse, over the 1 s in which the loads act
            numbers = [f"{simulation.dt:.4g}", simulation.n_steps, f"{energy:.5f}", f"{reaction:.3f}"]
            yield [kind, how, body.n_points, *numbers, *facts]


def cube(n: int, kind: str, how: str) -> dict[str, object]:
    """A cube whose bottom is held and whose top moves up, to its steady state."""
    block = {"name": "block", "kind": "meshless-solid", "material": TISSUE, "approximant": {"kind": kind}, "essential": how}
    mesh = {"box": {"lower": (0, 0, 0), "upper": (EDGE, EDGE, EDGE), "cells": (n, n, n)}}
    low, high = ({"box": {"lower": (-1, -1, z - 1e-4), "upper": (1, 1, z + 1e-4)}} for z in (0.0, EDGE))
    rise = {"z": {"kind": "steady", "velocity": PULL}}
    return {
        "schema": 1,
        "title": "A cube between clamps",
        "time": {"end": 1.0},
        "steady": {"tolerance": 1e-5, "loading": 500},
        "body": [block | {"mesh": mesh}],
        "support": [{"where": low}],
        "motion": [{"name": "top", "body": "block", "part": high, "hold": ["x", "y"], "displacement": rise}],
    }


def write(name: str, rows: Iterator[list[object]]) -> None:
    with (HERE / name).open("w", newline="") as file:
        for row in rows:
            csv.writer(file).writerow(row)
            print(*row, flush=True)


if __name__ == "__main__":
    write("faces.csv", faces())
    write("pull.csv", pulls())
