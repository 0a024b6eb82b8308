"""Run folder of an oocyte pushed sideways by a pipette, computed from formulas instead of mechanics, for tests of pictures."""

from pathlib import Path

import numpy as np

from pellucid.case import loads
from pellucid.geometry.meshes.cells import Cells
from pellucid.geometry.surfaces.triangles import Icosphere
from pellucid.results.storage import frames
from pellucid.results.storage.run import Run
from pellucid.results.storage.run_folder import RunFolder

CENTRE = np.array([67.0, 65.0, 65.0])  # µm
RADIUS, AMPLITUDE, PERIOD = 50.0, 13.5, 100.0  # µm, µm, µs

CASE = """
schema = 1
title = "Synthetic oocyte"
[grid]
lower = [0, 0, 0]
upper = [150e-6, 130e-6, 130e-6]
cell = 10e-6
[time]
end = 100e-6
step = 5e-9
[[body]]
name = "zona"
kind = "membrane-points"
surface = {{ icosphere = {{ centre = [67e-6, 65e-6, 65e-6], radius = 50e-6, refinements = {refinements} }} }}
thickness = 8e-6
material = {{ kind = "linear-membrane", density = 1100, young_modulus = 17.9e3, poisson_ratio = 0.49 }}
"""

BODY = """
[[body]]
name = "{name}"
shape = {{ box = {{ lower = [0, 0, 0], upper = [1e-5, 1e-5, 1e-5] }} }}
points_per_cell = [1, 1, 1]
material = {{ kind = "linear-elastic", density = 1000, young_modulus = 1e3, poisson_ratio = 0.3 }}
"""


def lattice(lower, upper, spacing):
    axes = [np.arange(a + 0.5 * spacing, b, spacing) for a, b in zip(lower, upper, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def write(out: Path, refinements: int = 4, spacing: float = 5.0, instants: int = 5) -> Run:
    """Write frames of all bodies at equally spaced instants of a period to a folder, and return the run; spacing: distance
    of the points of the fluids [µm]."""
    case = loads(CASE.format(refinements=refinements) + "".join(map(BODY.format_map, bodies_named())))
    folder = RunFolder(out)
    with folder.made():
        folder.start(case)
    folder.fields("").parent.mkdir()
    zona, triangles = Icosphere(centre=(0, 0, 0), radius=1, refinements=refinements).triangulate()
    zona = CENTRE + RADIUS * zona
    box = lattice((0, 0, 0), (150, 130, 130), spacing)
    box = box[(box[:, 0] > 17) | (np.abs(box[:, 1:] - 65).max(axis=1) > 35)]  # no medium in the plate
    distance = np.linalg.norm(box - CENTRE, axis=1)
    fine = lattice(CENTRE - RADIUS, CENTRE + RADIUS, 0.6 * spacing)
    bodies = {
        "zona": (zona, Cells(triangles=triangles), 1.0),
        "cytoplasm": (fine[np.linalg.norm(fine - CENTRE, axis=1) < RADIUS - 2.0], None, 0.6 * spacing),
        "medium": (box[distance > RADIUS + 4.0], None, spacing),
        "pipette": (tube(), None, 0.8),
        "plate": (lattice((2, 30, 30), (17, 100, 100), 5.0), None, 5.0),
    }
    for name, (start, cells, size) in bodies.items():
        for k, time in enumerate(np.linspace(0.0, PERIOD, instants)):
            frame = fields(name, start, time, size)
            if k == 0:
                frames.create(folder.fields(name), instants, 0.0, frame, cells)
            else:
                frames.append(folder.fields(name), 1e-6 * time, frame)
    return Run(out)


def bodies_named():
    return [{"name": name} for name in ("cytoplasm", "medium", "pipette", "plate")]


def tube():
    """Return the points of a tube along x that touches the oocyte, with outer radius 5 µm and inner radius 4 µm."""
    around = lattice((0, -5, -5), (15, 5, 5), 0.8)
    distance = np.hypot(around[:, 1], around[:, 2])
    return around[(distance < 5.0) & (distance > 3.8)] + CENTRE + [RADIUS + 4.0, 0, 0]


def fields(name: str, start: np.ndarray, time: float, size: float) -> dict[str, np.ndarray]:
    push = AMPLITUDE * np.sin(2.0 * np.pi * time / PERIOD)
    near = np.exp(-((start - CENTRE - [RADIUS, 0, 0]) ** 2).sum(axis=1) / (2.0 * 15.0**2))
    if name in ("pipette", "plate"):
        near = np.full(len(start), float(name == "pipette"))
    position = start + np.outer(near, [0.0, push, 0.0])
    if name in ("zona", "cytoplasm"):
        position[:, 0] -= 4.0 * near * min(1.0, time / 20.0)
    wave = np.cos(0.12 * np.linalg.norm(start - CENTRE - [RADIUS, 0, 0], axis=1) - 0.1 * time)
    n = len(start)
    found = {
        "position": 1e-6 * position,
        "velocity": np.outer(near, [0.0, np.cos(2.0 * np.pi * time / PERIOD), 0.0]),
        "mass": np.full(n, 1000.0 * (1e-6 * size) ** 3),
        "density": np.full(n, 1000.0),
        "pressure": 1e4 * wave * np.exp(-np.abs(position[:, 0] - 117.0) / 40.0),
        "stress": np.outer(1e4 * near, [1.0, 0.0, 0.0, 0.0, 0.0, 0.3]),
        "id": np.arange(n),
    }
    if name in ("cytoplasm", "medium"):
        found["internal_energy"] = np.ones(n)
    if name == "zona":
        off = np.hypot(start[:, 1] - CENTRE[1], start[:, 2] - CENTRE[2])
        beside = np.abs(start[:, 1] - CENTRE[1]) > 0.6 * off
        found["failed"] = ((np.abs(off - 8.0) < 0.045 * time) & beside & (start[:, 0] > 80.0)).astype(float)
    return found
