"""Tetrahedral mesh of a heart with two ventricles, built from truncated ellipsoids, with named node sets."""

import numpy as np

from pellucid.findings import Refusal
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.geometry.solid_meshes.contract import Tetrahedral
from pellucid.geometry.solid_meshes.fill import stuffed
from pellucid.model import check, parameter

LEFT, LEFT_WALL = np.array([0.022, 0.022, 0.045]), 0.005  # semi-axes of the cavity, and thickness of the wall [m]
RIGHT, RIGHT_WALL = np.array([0.032, 0.023, 0.043]), 0.004
OFFSET = np.array([0.010, 0.0, 0.0])  # of the centre of the right ventricle [m]
WIDTH, HEIGHT = 0.07, 0.062  # of the whole heart [m]
BASE = 0.010  # height of the plane of the base [m]
PATCH_HEIGHT = -0.015  # of the centre of the patch [m]


class HeartMesh(Tetrahedral):
    """A heart with two ventricles, ellipsoids about the z axis truncated at z = 10 mm, 62 mm high; the right one lies towards
    +x.

    Node sets: base, apex, epi, lv-endo, rv-endo, rv-patch.
    """

    size: float = parameter(
        "m",
        "edge length of the cubes of the lattice; with 1.5 mm, at least three edges "
        "cross the wall of the right ventricle below the base",
        gt=0,
        le=0.0035,
    )
    apex_height: float = parameter("m", "height of the cap at the apex; its outer nodes form the set apex", 0.005, gt=0)
    patch_radius: float = parameter(
        "m", "radius of the patch on the right wall; its outer nodes form the set rv-patch", 0.010, gt=0
    )

    @check
    def _can_be_made(self) -> None:
        sets = self.mesh().sets
        outer = self.mesh().nodes[sets["epi"]]
        for name, key, least in (
            ("apex", "apex_height", float(_above_apex(outer).min())),
            ("rv-patch", "patch_radius", float(_from_patch(outer).min())),
        ):
            if not len(sets[name]):
                text = f"`{key}` = {getattr(self, key):g} m is too small: no outer node lies within it, so set {name} is empty"
                raise Refusal(text, f"set `{key}` to at least {least * 1.01:.3g} m, or decrease `size`")

    def expected_points(self) -> float:
        across = WIDTH / self.size
        return 2.0 * across * across * (HEIGHT / self.size)

    def make(self) -> SimplexMesh:
        """Return the mesh; nodes of the base lie in a plane, other boundary nodes on the ellipsoids."""
        lower = np.minimum(-LEFT - LEFT_WALL, OFFSET - RIGHT - RIGHT_WALL)
        upper = np.maximum(LEFT + LEFT_WALL, OFFSET + RIGHT + RIGHT_WALL)
        upper[2] = BASE
        n = np.ceil((upper - lower) / self.size).astype(int) + 1
        start = 0.5 * (lower + upper - self.size * n)
        start[2] = BASE - self.size * n[2]
        counts = int(n[0]), int(n[1]), int(n[2])
        mesh = stuffed(lambda points: _boundaries(points).min(axis=0) >= 0.0, start, counts, self.size)
        return SimplexMesh(mesh.nodes, mesh.cells, self._sets(mesh))

    def _sets(self, mesh: SimplexMesh) -> dict[str, np.ndarray]:
        faces = mesh.faces[0][mesh.boundary]
        at_base = np.abs(mesh.nodes[:, 2] - BASE) < 1e-9
        sides = faces[~at_base[faces].all(axis=1)]
        nearest = np.argmin(np.abs(_boundaries(mesh.nodes[sides].mean(axis=1))), axis=0)
        sets = {name: np.unique(sides[nearest == k]) for k, name in enumerate(("epi", "lv-endo", "rv-endo"))}
        outer = mesh.nodes[sets["epi"]]
        apex, patch = _above_apex(outer) <= self.apex_height, _from_patch(outer) <= self.patch_radius
        return sets | {"base": np.flatnonzero(at_base), "apex": sets["epi"][apex], "rv-patch": sets["epi"][patch]}


def _above_apex(places: np.ndarray) -> np.ndarray:
    """Return the heights of positions [m], shape (n, 3), above the apex [m], shape (n,)."""
    return np.asarray(places[:, 2] + (LEFT + LEFT_WALL)[2])


def _from_patch(places: np.ndarray) -> np.ndarray:
    """Return the distances of positions [m], shape (n, 3), from the centre of the patch on the right ventricle [m], shape
    (n,)."""
    semi = RIGHT + RIGHT_WALL
    middle = OFFSET + np.array([semi[0] * np.sqrt(1.0 - (PATCH_HEIGHT / semi[2]) ** 2), 0.0, PATCH_HEIGHT])
    return np.asarray(np.linalg.norm(places - middle, axis=1))


def _boundaries(points: np.ndarray) -> np.ndarray:
    """Return approximate distances of points to the outer surface, the left and the right cavity [m], shape (3, n).

    All three are positive in the walls.
    """
    left = _inside(points, LEFT + LEFT_WALL)
    outer = np.maximum(left, _inside(points - OFFSET, RIGHT + RIGHT_WALL))
    return np.stack([outer, -_inside(points, LEFT), np.maximum(-_inside(points - OFFSET, RIGHT), left)])


def _inside(points: np.ndarray, semi_axes: np.ndarray) -> np.ndarray:
    """Return the depth of points inside an ellipsoid about the origin, to first order in the distance [m], shape (n,),
    negative outside; semi_axes [m], shape (3,)."""
    squares = np.sum((points / semi_axes) ** 2, axis=1)
    slope = np.linalg.norm(points / semi_axes**2, axis=1)
    return np.asarray(0.5 * (1.0 - squares) / np.maximum(slope, 1.0 / semi_axes.max()))
