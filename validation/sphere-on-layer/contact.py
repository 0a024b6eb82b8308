"""Press a rigid sphere into a block, a meshless solid, by contact of surfaces, and compare the force with that of the layer.

python contact.py 0.1 0.07: cells of the grid over the radius; writes contact.csv. A quarter of the block, h = w = 2 R,
ν = 0.3, bonded, pressed to δ = 0.1 R. The mesh has the spacing of the grid to 0.5 R beside the axis and 0.3 R below the face,
and grows from there; the sphere is a driven cap of membrane elements of half a cell.
"""

import csv
import sys
import tempfile
from pathlib import Path

import meshlane
import numpy as np

from pellucid.case import Case
from pellucid.geometry.solid_meshes.box import BoxMesh
from pellucid.references.solids import Layer, force
from pellucid.simulation.simulation import Simulation

RADIUS, MODULUS, POISSON, THICKNESS, DEPTH = 1.0, 1e5, 0.3, 2.0, 0.1
SKIN, GAP = 0.002, 0.02  # thickness of the membrane, height of the sphere above the block at the start
PRESS, HOLD, MEAN = 1.0, 0.8, 0.15  # s; the force is the mean over the last of them
GROWTH = 1.35
WITHIN = 0.25  # of the axis, where the face lies on the sphere (the radius of contact is 0.32)
COLUMNS = ("cell", "force_over_layer", "mean_gap", "least_gap", "largest_gap", "nodes", "steps")


def spaced(h, fine):
    """Places from 0 to the thickness, h apart to `fine`, then further and further apart."""
    places, step = list(np.arange(round(fine / h) + 1) * h), h
    k = len(places) - 1
    while places[-1] < THICKNESS:
        step *= GROWTH
        places.append(places[-1] + step)
    x = np.array(places)
    x[k:] = x[k] + (x[k:] - x[k]) * (THICKNESS - x[k]) / (x[-1] - x[k])
    return x


def block(h, path):
    across, down = spaced(h, 0.5), THICKNESS - spaced(h, 0.3)[::-1]
    axes = (across, across, down)
    counts = np.array([len(axis) - 1 for axis in axes])
    mesh = BoxMesh(lower=(0, 0, 0), upper=(1, 1, 1), cells=tuple(counts.tolist())).mesh()
    place = [np.interp(mesh.nodes[:, d] * counts[d], np.arange(len(axis)), axis) for d, axis in enumerate(axes)]
    meshlane.Mesh(np.stack(place, axis=1), [("tetra", mesh.cells)]).write(path)


def cap(h, path):
    n, radius = round(0.6 / h), RADIUS - SKIN / 2
    x, y = np.meshgrid(*[np.linspace(0, 0.6, n + 1)] * 2, indexing="ij")
    number = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
    places = np.stack([x, y, -np.sqrt(radius**2 - x**2 - y**2)], axis=-1).reshape(-1, 3)
    meshlane.Mesh(places, [("quad", quads)]).write(path)


def pressed(h, folder):
    """Force on the sphere over the layer's force; gaps between face and sphere near the axis; nodes, steps."""
    block(h, folder / "block.vtk")
    cap(0.5 * h, folder / "cap.vtk")
    tissue = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": MODULUS, "poisson_ratio": POISSON}
    skin = {"kind": "linear-membrane", "density": 1000.0, "young_modulus": 1e3, "poisson_ratio": 0.0}
    surface = {"file": {"path": str(folder / "cap.vtk"), "offset": (0, 0, THICKNESS + RADIUS + GAP)}}
    push = {"kind": "ramp", "distance": -(DEPTH + GAP), "duration": PRESS}
    upper = [float(np.ceil(size / h - 1e-9) * h) for size in (2.15, 2.15, 2.65)]
    base = {"box": {"lower": (-1, -1, -1e-6), "upper": (9, 9, 1e-6)}}
    case = {
        "schema": 1,
        "title": "a sphere on a layer",
        "grid": {"lower": (0, 0, 0), "upper": upper, "cell": h},
        "time": {"end": PRESS + HOLD, "courant": 0.5},
        "body": [
            {"name": "block", "field": "block", "kind": "meshless-solid", "damping": 20.0, "material": tissue}
            | {"mesh": {"file": {"path": str(folder / "block.vtk")}}},
            {"name": "ball", "field": "ball", "kind": "membrane-elements", "surface": surface, "thickness": SKIN}
            | {"material": skin},
        ],
        "support": [
            {"name": "base", "body": "block", "where": base},
            {"where": "x-lower", "fix": "normal"},
            {"where": "y-lower", "fix": "normal"},
        ],
        "motion": [{"name": "push", "body": "ball", "hold": ["x", "y"], "displacement": {"z": push}}],
        "contact": [{"name": "touch", "between": ["block", "ball"]}],
        "energy": {"warn": 1e3, "stop": 1e4},
    }
    simulation, times, impulse = Simulation(Case.model_validate(case)), [0.0], [0.0]
    while simulation.time < PRESS + HOLD - 1e-9:
        simulation.step()
        times.append(simulation.time)
        impulse.append(-4.0 * float(simulation.budget.reactions()["touch"][2]))
    found = (impulse[-1] - float(np.interp(times[-1] - MEAN, times, impulse))) / MEAN
    body = simulation.bodies[0]
    at = body.places()[body.mesh.nodes[:, 2] > THICKNESS - 1e-9]
    beside = np.hypot(at[:, 0], at[:, 1]) < WITHIN
    gap = np.linalg.norm(at[beside] - (0.0, 0.0, THICKNESS + RADIUS - DEPTH), axis=1) - RADIUS
    share = found / force(Layer(MODULUS, POISSON, THICKNESS, True), RADIUS, DEPTH)
    return share, gap.mean(), gap.min(), gap.max(), len(body.mesh.nodes), simulation.n_steps


if __name__ == "__main__":
    rows = []
    for argument in sys.argv[1:] or ["0.1", "0.07"]:
        with tempfile.TemporaryDirectory() as name:
            *numbers, nodes, steps = pressed(float(argument), Path(name))
        rows.append([argument, *(f"{number:.4f}" for number in numbers), nodes, steps])
        print(*rows[-1], flush=True)
    with open(Path(__file__).with_name("contact.csv"), "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([COLUMNS, *rows])
