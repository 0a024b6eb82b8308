"""The volume that a membrane encloses, with the areas by which a pressure in it pushes."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pellucid.conditions.enclosed.problems import FLAT
from pellucid.geometry.algorithms.lids import Lids
from pellucid.parts.annotations import AssembledBody, Assembly, Body
from pellucid.parts.capabilities import Membrane

FAILED = "failed"  # field of membranes that damage can tear


class Enclosure(NamedTuple):
    """A volume at an instant; areas and places are those of each body, in the order of the numbers of its points. Points that
    have failed have no area: no pressure acts on the hole that they leave."""

    volume: float  # [m³]
    areas: list[np.ndarray]  # (n, 3) of each, outwards of the volume [m²]
    places: list[np.ndarray]  # (n, 3) of each [m]
    failed: list[int]  # of the points of each that bear no stress any more
    hole: float = 0.0  # area of the holes that those leave in the outer membrane [m²]

    def swept(self, other: "Enclosure") -> float:
        """The volume that the membranes sweep from here to another instant, without that of lids [m³]."""
        bodies = zip(self.areas, other.areas, self.places, other.places, strict=True)
        return sum(float(np.sum(0.5 * (area + later) * (there - place))) for area, later, place, there in bodies)


class EnclosedVolume:
    """⅓∮x·n dA over a membrane and, of one that is open, the lids over its rims, less the volumes of closed ones inside it.

    Its gradients by the places of the points are the areas by which a pressure pushes these, where there is no lid.
    """

    def __init__(self, outer: str, inside: Sequence[str], assembly: Assembly, channel: str) -> None:
        """channel: of the work of the pressure. A membrane whose normals point inwards counts as if they did outwards."""
        self.members: list[AssembledBody] = [assembly.bodies[name] for name in (outer, *inside)]
        self._add = [assembly.forces_on(name, channel) for name in (outer, *inside)]
        self._lids = [Lids(body.places(), body.cells().surface()) for body in self.bodies]
        self.is_open = len(self._lids[0].rims.edges) > 0
        self._signs = [1.0] * len(self.members)
        volumes = [self._of(number)[0] for number in range(len(self.members))]
        extent = float(np.ptp(self.bodies[0].places(), axis=0).max())
        inwards = [volume < -FLAT * extent**3 for volume in volumes]
        self._signs = [-1.0 if turned != (number > 0) else 1.0 for number, turned in enumerate(inwards)]
        self.is_flat = abs(volumes[0]) <= FLAT * extent**3

    @property
    def bodies(self) -> list[Body]:
        """The membrane, and those inside."""
        return [member.body for member in self.members]

    def now(self) -> Enclosure:
        """Return the present volume, areas and holes."""
        volumes, areas, places = zip(*(self._of(number) for number in range(len(self.members))), strict=True)
        holes = [failed_points(body) for body in self.bodies]
        for area, failed in zip(areas, holes, strict=True):
            area[failed] = 0.0
        hole = float(self._membrane.surface_areas()[holes[0]].sum()) if len(holes[0]) else 0.0
        return Enclosure(sum(volumes), list(areas), list(places), [len(failed) for failed in holes], hole)

    @property
    def _membrane(self) -> Membrane:
        return self.members[0].offers(Membrane)

    def _of(self, number: int) -> tuple[float, np.ndarray, np.ndarray]:
        sign, member = self._signs[number], self.members[number]
        places = member.body.places()
        areas = member.offers(Membrane).pressed_areas()
        return sign * self._lids[number].volume(places, areas), sign * areas, places

    def press(self, now: Enclosure, pressure: float) -> None:
        """Apply a gauge pressure [Pa] to the membranes over this step."""
        for body, add, areas in zip(self.bodies, self._add, now.areas, strict=True):
            add((pressure * areas)[body.stored_array("id")])

    def membrane_area(self) -> float:
        """Area of the outer membrane including its holes [m²]."""
        return float(self._membrane.surface_areas().sum())

    def mobility(self, now: Enclosure) -> float:
        """Return the acceleration of the volume per unit pressure, Σ A²/m [m⁴/kg], if nothing else has mass."""
        masses = [np.asarray(body.field("mass")) for body in self.bodies]
        return sum(float(np.sum(np.sum(a * a, axis=1) / m)) for a, m in zip(now.areas, masses, strict=True))

    def growth(self, now: Enclosure) -> float:
        """The rate of the volume by the velocities of the points [m³/s]."""
        velocities = [np.asarray(body.field("velocity")) for body in self.bodies]
        return sum(float(np.sum(a * v)) for a, v in zip(now.areas, velocities, strict=True))

    def swing(self, rate: float) -> bool:
        """Bound the steps of its membranes where the volume swings at half this rate [1/s] beside what else they do; whether it
        is faster than that."""
        governs = all(rate > body.totals.rate for body in self.bodies)
        for body in self.bodies:
            body.totals.rate = float(np.hypot(body.totals.rate, rate))
        return governs


def failed_points(body: Body) -> np.ndarray:
    """Numbers of the points of a membrane that bear no stress any more, shape (k,)."""
    if FAILED not in body.field_names:
        return np.zeros(0, np.int64)
    return np.flatnonzero(np.asarray(body.field(FAILED)) > 0.0)
