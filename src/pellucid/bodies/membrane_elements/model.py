"""Membranes of finite elements as the user describes them."""

from collections.abc import Iterator, Sequence
from math import ceil, sqrt
from typing import Any, ClassVar, Literal

import numpy as np

from pellucid.bodies.membrane_elements.hourglass import HourglassCase
from pellucid.geometry.geometry import Geometry
from pellucid.geometry.inside import Inside
from pellucid.geometry.mesh import Mesh
from pellucid.geometry.surface_checks import mesh_faults
from pellucid.geometry.surfaces import Elements, Surface
from pellucid.grid.model import GridCase
from pellucid.materials import MembraneMaterial
from pellucid.model import Model, Vector, parameter

FIELD_MEANING = "velocity field: bodies of one field move together, those of different fields touch by contact"
SLACK = 1e-9  # of a length, for rounding


class MembraneElementsCase(Model):
    """A membrane of finite elements, which moves on its own nodes and meets other bodies on the grid."""

    kind: Literal["membrane-elements"] = "membrane-elements"
    name: str = parameter("", "name of the body, used for its files and in probes", pattern=r"^[A-Za-z][A-Za-z0-9_-]*$")
    field: str = parameter("", FIELD_MEANING, "common", pattern=r"^[A-Za-z][A-Za-z0-9_-]*$")
    surface: Surface = parameter("", "where the membrane is at the start")
    elements: Elements = parameter(
        "", "quadrilaterals where the surface has them, or triangles alone: each quadrilateral cut in two", "quads"
    )
    thickness: float = parameter("m", "initial thickness", gt=0)
    material: MembraneMaterial = parameter("", "what the membrane is made of")
    hourglass: HourglassCase = parameter("", "hourglass control of its quadrilaterals", HourglassCase())
    velocity: Vector = parameter("m/s", "initial velocity", (0.0, 0.0, 0.0))

    place: ClassVar[str] = "surface"

    @property
    def probed(self) -> tuple[str, ...]:
        """The fields that probes can read."""
        motion = ("position", "velocity", "mass", "kinetic_energy")
        return (*motion, "density", "pressure", "stress", "thickness", "stored_energy", "strain_energy")

    def mesh(self) -> Mesh:
        """Its elements at the start."""
        return self.surface.mesh(self.elements)

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner [m]."""
        vertices = self.mesh().vertices
        return vertices.min(axis=0), vertices.max(axis=0)

    def knowing(self, bodies: Sequence[Any]) -> "MembraneElementsCase":
        """Itself: a membrane leaves nothing out."""
        return self

    @property
    def moves_rigidly(self) -> bool:
        """No: a membrane has no rigidity."""
        return False

    def wave_speeds(self) -> tuple[float, float]:
        """Speeds of pressure and shear waves in its plane at the start [m/s]."""
        return self.material.wave_speeds()

    def occupied(self) -> Geometry:
        """What it encloses: the place that bodies outside it leave out."""
        return Inside(surface=self.surface)

    def size(self, grid: GridCase) -> float:
        """Number of nodes."""
        return len(self.mesh().vertices)

    def grid_problems(self, grid: GridCase) -> Iterator[tuple[str, str, str]]:
        """What does not fit the grid: key, text, remedy."""
        if self.material.damage:
            text = "elements have no law of damage: an element that failed would leave a hole that nothing stops at"
            yield "material", text, "leave out `damage`, or use kind membrane-points"
        mesh = self.mesh()
        wrong = [("surface", text, remedy) for text, remedy in mesh_faults(mesh, self.surface.closed)]
        yield from wrong
        if wrong:
            return
        thin, reach = grid.thin(), sqrt(0.5) * grid.cell
        places = np.where(thin, 0.0, mesh.vertices)  # along a thin axis nothing varies, so that distances do not count
        longest, remote = longest_edge(places[mesh.quads]), 0.0
        if any(thin):
            longest = max(longest, longest_edge(places[mesh.triangles]))
        else:
            remote = float(_remoteness(places[mesh.triangles]).max(initial=0.0))
        pass_through = "between its nodes other bodies would pass through the membrane"
        if longest > grid.cell * (1.0 + SLACK):
            text = f"has an element with an edge of {longest:.3g} m, longer than a cell of {grid.cell:g} m: {pass_through}"
            yield "surface", text, _finer(longest / grid.cell)
        elif remote > reach * (1.0 + SLACK):
            text = f"has a triangle that reaches {remote:.3g} m from its corners, with cells of {grid.cell:g} m more than"
            yield "surface", f"{text} {reach:.3g} m: {pass_through}", _finer(remote / reach)


def _finer(times: float) -> str:
    return f"make its elements {ceil(times)} times as fine along each edge, or use a larger grid.cell"


def longest_edge(places: np.ndarray) -> float:
    """Of all elements [m]; places of their corners: shape (m, corners, 3)."""
    return float(np.linalg.norm(places - np.roll(places, 1, axis=1), axis=2).max(initial=0.0))


def _remoteness(places: np.ndarray) -> np.ndarray:
    """How far the remotest point of each triangle is from its nearest corner [m]; places: shape (m, 3, 3).

    The centre of the circumscribed circle where no angle is obtuse, else a point of the longest edge; of a square cut in two it
    is the middle of the square.
    """
    edges = np.linalg.norm(places - np.roll(places, 1, axis=1), axis=2)
    a, b, c = np.sort(edges, axis=1).T
    cos_a, cos_b = (b * b + c * c - a * a) / (2.0 * b * c), (a * a + c * c - b * b) / (2.0 * a * c)
    cos_c = np.maximum((a * a + b * b - c * c) / (2.0 * a * b), 0.0)
    acute = c / (2.0 * np.sqrt(1.0 - cos_c * cos_c))
    obtuse = np.maximum(b / (2.0 * cos_a), a / (2.0 * cos_b))
    return np.asarray(np.where(a * a + b * b >= c * c, acute, obtuse))
