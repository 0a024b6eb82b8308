"""Cases of an oocyte pressed by a wall or a sheet: an eighth of an inflated sphere filled with liquid, between planes of
symmetry."""

import numpy as np

RADIUS, THICKNESS = 50e-6, 8e-6
WAYS = 1e-6 * np.array([4.0, 6.0, 8.0, 10.0, 12.0])
FORCES = 1e-9 * np.array([157.1, 292.8, 471.6, 703.9, 1001.6])
"""Force of the whole sphere on a flat plate [N], for the displacements WAYS of the plate since first contact [m], from the
least energy of the membrane as a chain of cones; a solution of the equations of an axisymmetric membrane by shooting agrees
to 1e-4."""
PRESSURE = 218.4  # Pa, at which the sphere is at rest


def pressed_oocyte(start, speed=0.02, end=6.3e-4, divisions=8, plate="wall", **zona):
    """Return the table of a case in which a plate, i.e. a wall or a sheet of 1 um, moves down at a speed [m/s] from a
    height `start` [m]."""
    sphere = {"centre": [0, 0, 0], "radius": RADIUS, "divisions": divisions, "part": {"lower": [-1e-9] * 3, "upper": [1, 1, 1]}}
    body = {
        "name": "zona",
        "kind": "membrane-elements",
        "elements": "triangles",
        "surface": {"sphere": sphere},
        "thickness": THICKNESS,
        "inflation": 0.02,
        "damping": 2000.0,
        "material": {"kind": "neo-hookean-membrane", "density": 1100.0, "young_modulus": 17.9e3, "poisson_ratio": 0.49},
    }
    liquid = {"pressure": PRESSURE, "bulk_modulus": 2e5, "density": 1000.0}
    bodies, parts = [body | zona], {}
    if plate == "wall":
        parts["wall"] = [{"name": "plate", "point": [0, 0, start], "normal": [0, 0, -1], "velocity": [0, 0, -speed]}]
    else:
        rectangle = {"corner": [0, 0, start], "first_edge": [80e-6, 0, 0], "second_edge": [0, 80e-6, 0], "points": [7, 7]}
        material = {"kind": "linear-membrane", "density": 1000.0, "young_modulus": 100.0, "poisson_ratio": 0.3}
        sheet = {"name": "plate", "field": "plate", "kind": "membrane-elements", "surface": {"rectangle": rectangle}}
        bodies.append(sheet | {"thickness": 1e-6, "material": material})
        down = {"kind": "steady", "velocity": -speed}
        parts["motion"] = [{"name": "press", "body": "plate", "hold": ["x", "y"], "displacement": {"z": down}}]
        parts["contact"] = [{"name": "plate", "between": ["zona", "plate"]}]
    return parts | {
        "schema": 1,
        "title": "An oocyte is pressed",
        "grid": {"lower": [0, 0, 0], "upper": [90e-6] * 3, "cell": 15e-6},
        "time": {"end": end},
        "body": bodies,
        "support": [{"where": ["x-lower", "y-lower", "z-lower"], "fix": "normal"}],
        "enclosed": [{"name": "cytoplasm", "body": "zona", "lids": True, "liquid": liquid}],
    }


def force_on_plate(sim, speed, every=20):
    """Run a simulation, and return the mean displacements of the wall [m] and the mean forces of the whole sphere on it [N]
    over intervals of `every` steps, shape (2, intervals)."""
    rows, before = [], (0.0, 0.0)
    for _ in sim:
        if sim.n_steps % every == 0:
            now = sim.time, sim.budget.reactions()["plate"][2]
            force = -4.0 * (now[1] - before[1]) / (now[0] - before[0])
            rows.append((0.5 * speed * (now[0] + before[0]), force))
            before = now
    return np.array(rows).T
