"""The surface of a solid of material points, by which others touch it.

Points of the surface are moved by the grid as those within are: each has an anchor in the layer of the outermost material
points, where the nodes that reach it have mass, and lies above it along the normal, at a depth that stays. So a surface comes
nearer by the velocity of its anchors, at which forces act: what these take and give is the same. That velocity is the one that
strains the points, as the energy of the overlap is stored like that of a strain. With its gradient L at the anchor the vector
area a changes by tr(L) a - Lᵀ a, as areas of the material do.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy import uintp

from pellucid.contact.contact_surface import ContactSurface
from pellucid.grid.lattice import Lattice
from pellucid.grid.stencil import gather, gather_gradient, stencil
from pellucid.grid.vectors import scatter_listed
from pellucid.jit import kernel, pointwise
from pellucid.jit.bundle import Bundle
from pellucid.jit.parallel import parallel_for

CHUNK = 256  # points that a thread takes at a time
WIDTHS = 2.5  # distances between its points over which the weights of one reach


class MovedSurface(NamedTuple):
    """Points of a surface and the nodes that move them."""

    functions: Any  # shape functions along x, y, z
    lattice: Lattice
    velocity: np.ndarray  # (nodes, 3) along which internal forces work on the points: that which strains them [m/s]
    anchor: np.ndarray  # (m, 3) [m]
    area: np.ndarray  # (m, 3) [m²]
    motion: np.ndarray  # (m, 3) velocity of the anchors in the last step [m/s]


@pointwise
def within(lattice, x, p):
    """Whether point p lies within the grid, along the axes that are more than one cell thick."""
    inside = True
    for d in range(3):
        place = (x[p, d] - lattice.lower[d]) * lattice.inverse_cell
        inside = inside and (lattice.counts[d] == 1 or 0.0 <= place <= lattice.counts[d])
    return inside


@kernel(inner=True)
def _follow_chunk(chunk, surface, dt):
    functions, lattice, x, a = surface.functions, surface.lattice, surface.anchor, surface.area
    for p in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(x))):
        if not within(lattice, x, p):
            a[p, 0] = a[p, 1] = a[p, 2] = 0.0  # it left the grid, and touches nothing any more
            continue
        about = stencil(functions, lattice, x, uintp(p))
        v = gather(about, lattice, surface.velocity)
        xx, xy, xz, yx, yy, yz, zx, zy, zz = gather_gradient(about, lattice, surface.velocity)
        a0, a1, a2, growth = a[p, 0], a[p, 1], a[p, 2], xx + yy + zz
        a[p, 0] += dt * (growth * a0 - xx * a0 - yx * a1 - zx * a2)
        a[p, 1] += dt * (growth * a1 - xy * a0 - yy * a1 - zy * a2)
        a[p, 2] += dt * (growth * a2 - xz * a0 - yz * a1 - zz * a2)
        for d in range(3):
            surface.motion[p, d] = v[d]
            x[p, d] += dt * v[d]


@kernel()
def _follow(chunks, surface, dt):
    parallel_for(_follow_chunk, chunks, surface, dt)


class GridSurface(ContactSurface):
    """Points at places [m] with vector areas [m²], shape (m, 3), of a body on the grid.

    mapped: of the body; depth: of the outermost material points below the surface [m]; spacing: of the surface's points [m];
    load: forces on the nodes, shape (nodes, 3), to which those on the surface are added.
    """

    follows_steps = False  # stiffer layers shake the nodes about them, and transfers take what they shake

    def __init__(
        self,
        mapped: Bundle,
        place: np.ndarray,
        area: np.ndarray,
        depth: float,
        spacing: float,
        load: Callable[[], np.ndarray],
        velocity: np.ndarray,
    ) -> None:
        self.area, self._depth = area.copy(), depth
        self.place, self.anchor = place.copy(), place - self._above()
        self.velocity, self.slip = velocity.copy(), np.zeros_like(place)
        self.reach = np.full(len(place), WIDTHS * spacing)
        self._load = load
        nodes = mapped.nodes
        moved = MovedSurface(
            mapped.functions,
            mapped.lattice,
            nodes.strain_velocity,
            self.anchor,
            self.area,
            self.velocity,
        )
        self._moved = Bundle(moved)

    def _above(self) -> np.ndarray:
        """From the anchors to the surface [m], shape (m, 3)."""
        size = np.linalg.norm(self.area, axis=1, keepdims=True)
        return self._depth * self.area / np.where(size > 0.0, size, 1.0)

    def begin(self) -> None:
        """Put the points on the surface."""
        np.add(self.anchor, self._above(), out=self.place)

    def follow(self, dt: float) -> None:
        """Move with the nodes over a step dt [s]."""
        _follow(len(self.anchor) // CHUNK + 1, self._moved, dt)

    def turn(self, centre: np.ndarray, rotation: np.ndarray, new_centre: np.ndarray, dt: float) -> None:
        """Move as a rigid body whose centre goes to a new place [m], (3,), and which turns by a rotation, (3, 3), in dt [s]."""
        arm = self.anchor + self._above() - centre
        self.anchor[...] = new_centre + (self.anchor - centre) @ rotation.T
        self.area[...] = self.area @ rotation.T
        if dt > 0.0:
            self.velocity[...] = (new_centre - centre + arm @ rotation.T - arm) / dt

    def add_forces(self, force: np.ndarray) -> None:
        """To the nodes about the anchors."""
        listed = np.flatnonzero(force.any(axis=1))
        scatter_listed(self._moved, self.anchor, listed, force[listed], self._load())

    def state_arrays(self) -> Mapping[str, np.ndarray]:
        """What a checkpoint keeps."""
        names = ("anchor", "area", "velocity", "slip")
        return {f"surface/{name}": getattr(self, name) for name in names}
