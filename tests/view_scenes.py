"""A run folder with everything that the interactive view can show: balls in a skin of triangles that fails, and a block of
tetrahedra."""

from pathlib import Path

import numpy as np
from meshes import irregular

from pellucid.case import loads
from pellucid.geometry.meshes.cells import Cells
from pellucid.geometry.surfaces.triangles import Icosphere
from pellucid.results.storage import frames
from pellucid.results.storage.run import Run

CASE = """
schema = 1
title = "A skin <about> balls"
[grid]
lower = [0, 0, 0]
upper = [4, 2, 2]
cell = 0.5
[time]
end = 1.0
step = 0.05
[[body]]
name = "core"
kind = "material-points"
shape = { sphere = { centre = [1, 1, 1], radius = 0.5 } }
material = { kind = "fluid", density = 1.0, pressure = 1.0, eos = { kind = "ideal-gas", gamma = 1.4 } }
[[body]]
name = "skin"
kind = "membrane-points"
surface = { icosphere = { centre = [1, 1, 1], radius = 0.6, refinements = 1 } }
thickness = 0.01
material = { kind = "linear-membrane", density = 1000, young_modulus = 1e3, poisson_ratio = 0.3 }
[[body]]
name = "block"
kind = "material-points"
shape = { box = { lower = [2.5, 0.5, 0.5], upper = [3.5, 1.5, 1.5] } }
material = { kind = "linear-elastic", density = 1000, young_modulus = 1e3, poisson_ratio = 0.3 }
[output]
history = 0.25
frames = 0.25
checkpoint = 1000
"""

TIMES = np.linspace(0.0, 1.0, 5)
MIDDLE = np.array([1.0, 1.0, 1.0])


def ball(n: int) -> np.ndarray:
    """Return the points of a lattice, with n points along an edge, that lie within a sphere [m], shape (k, 3)."""
    places = np.stack(np.meshgrid(*[np.linspace(-0.5, 0.5, n)] * 3, indexing="ij"), -1).reshape(-1, 3)
    return MIDDLE + places[np.linalg.norm(places, axis=1) <= 0.5]


def write_run(out: Path, across: int = 8, **settings: object) -> Run:
    """Write the run to a folder and return it; across: number of points of the core along a diameter. All bodies move along
    x. The skin fails at large x, more of it at each instant, and a point of the core leaves at the last instant."""
    run = Run(out)
    with run.folder.made():
        run.folder.start(loads(CASE).with_settings(settings))
    core, mesh = ball(across), irregular(3, 3)
    skin = Icosphere(centre=tuple(MIDDLE), radius=0.6, refinements=2).triangulate()
    bodies = {
        "core": (core, Cells.of_points(len(core)), 0.5**3 / len(core)),
        "skin": (skin.vertices, Cells(triangles=skin.triangles), 1e-4),
        "block": (mesh.nodes + np.array([2.5, 0.5, 0.5]), Cells(tetrahedra=mesh.cells), 1e-2),
    }
    for name, (start, cells, volume) in bodies.items():
        for k, time in enumerate(TIMES):
            frame = fields_of(name, start, volume, float(time))
            if k == 0:
                frames.create(_path(run, name), len(TIMES), 0.0, frame, cells)
            else:
                frames.append(_path(run, name), float(time), frame)
    return run


def fields_of(name: str, start: np.ndarray, volume: float, time: float) -> dict[str, np.ndarray]:
    """Return the fields of a body at an instant [s], by name; start: initial positions [m]."""
    away = np.linalg.norm(start - MIDDLE, axis=1)
    mass = np.full(len(start), volume)
    if name == "core" and time == 1.0:
        mass[0] = 0.0
    fields = {
        "id": np.arange(len(start)),
        "mass": mass,
        "position": start + np.array([0.3 * time, 0.0, 0.0]),
        "velocity": np.column_stack([0.1 + away * time, 0.0 * away, 0.0 * away]),
        "density": np.ones(len(start)),
        "stress": np.outer(away * (1.0 + time), [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
    }
    if name == "skin":
        fields["failed"] = (start[:, 0] > 1.6 - 0.4 * time).astype(np.int64)
    return fields


def _path(run: Run, name: str) -> Path:
    run.folder.fields(name).parent.mkdir(exist_ok=True)
    return run.folder.fields(name)
