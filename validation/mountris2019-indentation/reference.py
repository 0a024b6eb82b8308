"""The indented cylinder and heart by tetrahedra of first and second order, on the very meshes of the gallery cases.

    python reference.py write CASE [quick] [KEY=VALUE...] MESH.npz    where the package is installed
    python reference.py solve MESH.npz STEPS [KIND...]                where FElupe is, which needs nothing of the package

The package gives nodes, tetrahedra, and which nodes are held or moved; all else is FElupe's, in displacements alone ("p1",
"p2": upper bounds but for quadrature) and with the mean volume ratio of each tetrahedron of second order in the volumetric
energy ("p2-p0": no locking). Prints energies and forces at each of so many equal steps. Newton's method:
../mountris2019-cube/statics.py.
"""

import sys
from pathlib import Path

import numpy as np

EDGES = np.array([[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]])  # between whose ends the nodes 4 to 9 stand
KINDS = {"p1": (1, False), "p2": (2, False), "p2-p0": (2, True)}  # order, and whether volume ratios are means


def write(name, *more):
    """Nodes, tetrahedra, displacements that are prescribed at the end, and the faces on which they are."""
    from pellucid.case import load, parse_setting
    from pellucid.simulation.simulation import Simulation

    case = load(name)
    *settings, path = more
    if "quick" in settings:
        case = case.quick_variant()
    case = case.with_settings(dict(parse_setting(text) for text in settings if "=" in text))
    body = Simulation(case, threads=1).bodies[0]
    rows, first = body.arrays["prescribed"], body.motion.motion_rows[0]
    end = np.zeros((len(rows), 3))
    moved = np.zeros(len(rows), bool)
    for number, motion in enumerate(case.motion):
        by = [motion.functions()[axis](case.time.end) for axis in range(3)]
        on = rows == first + number + 1
        end += on * np.array(by)
        moved |= on.any(axis=1)
    field = body.prescribed
    arrays = {"nodes": body.mesh.nodes, "cells": body.mesh.cells, "held": rows > 0, "end": end, "moved": moved}
    np.savez(path, faces=field.mesh.faces[0][field.faces], **arrays)


class Problem:
    """A mesh with its prescribed displacements, of first or second order."""

    def __init__(self, path, order):
        data = np.load(path)
        self.nodes, self.cells = data["nodes"], data["cells"]
        self.held, self.end, self.moved = data["held"], data["end"], data["moved"]
        if order == 2:
            n, between = len(self.nodes), np.sort(self.cells[:, EDGES], axis=2)
            pairs, number = np.unique(between.reshape(-1, 2), axis=0, return_inverse=True)
            on_faces = np.unique(np.sort(data["faces"][:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
            on_face = np.isin(pairs[:, 0] * n + pairs[:, 1], on_faces[:, 0] * n + on_faces[:, 1])[:, None]
            self.cells = np.hstack([self.cells, n + number.reshape(-1, 6)])
            self.nodes = np.vstack([self.nodes, self.nodes[pairs].mean(axis=1)])
            held = self.held[pairs].all(axis=1) & on_face & (self.end[pairs[:, 0]] == self.end[pairs[:, 1]])
            self.end = np.vstack([self.end, self.end[pairs[:, 0]] * held])
            self.moved = np.append(self.moved, self.moved[pairs].all(axis=1) & on_face[:, 0])
            self.held = np.vstack([self.held, held])


def static(problem, order, mean):
    """The equations of FElupe; `mean`: with the mean volume ratio of each element."""
    import felupe as fem

    sys.path.insert(0, str(Path(__file__).parent.parent / "mountris2019-cube"))
    from statics import LAWS, Static

    kind, region = ("tetra10", fem.RegionQuadraticTetra) if order == 2 else ("tetra", fem.RegionTetra)
    found = Static(region(fem.Mesh(problem.nodes, problem.cells, kind)), LAWS["coupled"])
    if mean:
        found.mixed, found.modes = True, np.ones((1, len(found.weights)))
        found.mass_inverse = 1.0 / found.weights.sum(axis=0)[:, None, None]
    return found


def solve(path, steps, *kinds):
    """Energy [J], force on the moved nodes along their way [N] and least volume ratio of a point, at each of so many steps."""
    for name in kinds or KINDS:
        order, mean = KINDS[name]
        problem = Problem(path, order)
        equations = static(problem, order, mean)
        try:
            for row in equilibria(equations, problem, int(steps)):
                print(name, *row, sep=",", flush=True)
        except FloatingPointError as error:
            print(f"# {name}: {error}", flush=True)


def equilibria(equations, problem, steps):
    """One after the other, each guessed along the last step, the first ones by the tangent at rest."""
    from pypardiso import spsolve
    from statics import minimize

    fixed = np.flatnonzero(problem.held.ravel())
    free, end = np.setdiff1d(np.arange(equations.size), fixed), problem.end.ravel()
    way = problem.end[problem.moved][0] / np.linalg.norm(problem.end[problem.moved][0])
    u, last = np.zeros(equations.size), np.zeros(equations.size)
    for step in range(1, steps + 1):
        guess = 2.0 * u - last
        guess[fixed] = step / steps * end[fixed]
        if step == 1 or equations.state(guess) is None:
            tangent, guess = equations.stiffness(equations.state(u)), u.copy()
            guess[fixed] = step / steps * end[fixed]
            guess[free] += spsolve(tangent[free][:, free].tocsr(), -(tangent[free][:, fixed] @ (guess - u)[fixed]))
        if equations.state(guess) is None:
            raise FloatingPointError(f"the guess at {step / steps:g} is inverted")
        last, (u, iterations) = u, minimize(equations, guess, fixed, 1e-8)
        state = equations.state(u)
        force = equations.forces(state).reshape(-1, 3)[problem.moved].sum(axis=0) @ way
        yield f"{step / steps:g}", f"{equations.energy(state):.6e}", f"{force:.6f}", f"{state[1].min():.3f}", iterations


if __name__ == "__main__":
    {"write": write, "solve": solve}[sys.argv[1]](*sys.argv[2:])
