"""Tetrahedral mesh that fills a closed surface and keeps its triangles, by TetGen (Si 2015, ACM Trans. Math. Softw. 41, 11)."""

import subprocess
import sys
from importlib.util import find_spec
from math import prod
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from pellucid.findings import Refusal
from pellucid.geometry.algorithms.crossing import self_crossing
from pellucid.geometry.algorithms.enclosure import enclosed_volume, inside
from pellucid.geometry.meshes.cells import vector_areas
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.geometry.meshes.triangulation import Triangulation
from pellucid.geometry.solid_meshes.contract import Tetrahedral
from pellucid.geometry.surfaces.inside import closed_triangles
from pellucid.geometry.surfaces.surface import Surface
from pellucid.model import check, parameter
from pellucid.system.extras import install_command

REGULAR = 6.0 * np.sqrt(2.0)  # cube of the edge of a regular tetrahedron over its volume
ROUNDING = 1e-9  # of the volume
AWAY = 1e-6  # of the extent: largest mean distance between mesh and surface where triangles meet at almost 180 degrees
MOST_OFF = 1e-5  # of the volume

# TetGen terminates the whole process on some self-intersecting surfaces, so it runs in a separate process
_TETGEN = """
import sys, numpy, tetgen
given = numpy.load(sys.argv[1])
mesher = tetgen.TetGen(given["vertices"], given["triangles"])
nodes, cells = mesher.tetrahedralize(
    plc=True, quality=True, minratio=1.5, mindihedral=10.0, fixedvolume=True, maxvolume=float(given["volume"]),
    nomergefacet=bool(given["apart"]))[:2]
numpy.savez(sys.argv[2], nodes=nodes, cells=cells)
"""


class InsideMesh(Tetrahedral):
    """A closed surface, such as an STL file, filled with tetrahedra by TetGen; its vertices become nodes, and sharp edges
    are kept."""

    surface: Surface = parameter("", "closed surface; a piece inside another piece is a hole")
    size: float = parameter("m", "approximate edge length of the largest tetrahedra", gt=0)

    @check
    def _can_be_made(self) -> None:
        self.mesh()

    def expected_points(self) -> float:
        corners = self.surface.mesh().vertices
        return prod(extent / self.size + 1.0 for extent in np.ptp(corners, axis=0).tolist())

    def make(self) -> SimplexMesh:
        """Run TetGen. Raises ValueError if TetGen is not installed, or the surface is not closed."""
        if find_spec("tetgen") is None:
            raise Refusal("the package tetgen, which is needed to fill a surface, is not installed", install_command("mesh"))
        surface = closed_triangles(self.surface)
        largest, reason = self.size**3 / REGULAR, Refusal("", "")
        for apart in (False, True):
            try:
                mesh = _filled(surface, largest, apart)
            except Refusal as refusal:
                reason = refusal
                continue
            if (off := _off(mesh, surface, ROUNDING if apart else None)) is None:
                return mesh
            reason = off
        raise reason


def _off(mesh: SimplexMesh, surface: Triangulation, slack: float | None) -> Refusal | None:
    """Return a refusal if the volume of the mesh differs from the volume inside the surface by more than a tolerance; else
    None.

    The tolerance is a fraction `slack` of the volume. If it is None, the mesh may deviate from the surface as much as flat
    parts are uneven when a file rounds their corners to six digits: TetGen treats triangles that meet at more than 179.9
    degrees as one flat part and does not keep the edges inside it. If that deviates too much, the edges are kept, which takes
    up to five times as many tetrahedra, of lower quality.
    """
    volume, found = enclosed_volume(*surface), float(mesh.volumes.sum())
    area = float(np.linalg.norm(vector_areas(*surface), axis=1).sum())
    extent = float(np.ptp(surface.vertices, axis=0).max())
    limit = slack * volume if slack is not None else min(AWAY * extent * area, MOST_OFF * volume)
    if abs(found - volume) <= limit:
        return None
    text = f"the volume of the tetrahedra is {found:.10g} m^3, but the surface encloses {volume:.10g} m^3"
    return Refusal(text, "check whether pieces of the surface overlap, and remove one of them")


def _filled(surface: Triangulation, volume: float, apart: bool) -> SimplexMesh:
    """Return tetrahedra of at most `volume` [m³] inside a closed surface; `apart`: keep every edge."""
    with TemporaryDirectory() as folder:
        given, made = Path(folder, "given.npz"), Path(folder, "made.npz")
        np.savez(given, vertices=surface.vertices, triangles=surface.triangles.astype(np.int32), volume=volume, apart=apart)
        call = [sys.executable, "-c", _TETGEN, str(given), str(made)]
        done = subprocess.run(call, capture_output=True, text=True, check=False, cwd=folder)  # a failed run leaves files behind
        if done.returncode or not made.is_file():
            raise _refusal(surface, done.stderr)
        with np.load(made) as found:
            nodes, cells = found["nodes"], found["cells"]
    within = inside(nodes[cells].mean(axis=1), *surface)  # TetGen fills holes as well
    used, which = np.unique(cells[within], return_inverse=True)
    return SimplexMesh(nodes[used], which.reshape(-1, 4))


def _refusal(surface: Triangulation, said: str) -> Refusal:
    place = self_crossing(surface)
    if place is not None:
        text = f"the surface intersects itself near ({', '.join(f'{x:.4g}' for x in place)}) m"
        return Refusal(text, "repair it there, or remove one of two overlapping pieces")
    last = said.strip().splitlines()[-1] if said.strip() else "no reason reported"
    return Refusal(f"TetGen could not fill the surface: {last}", "repair the surface, or use the more robust mesh `fill`")
