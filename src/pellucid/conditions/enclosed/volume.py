"""Volume enclosed by a membrane, and the vector areas of its points on which an enclosed pressure acts."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pellucid.conditions.enclosed.foretold import FLAT
from pellucid.geometry.meshes.enclosure import Lids
from pellucid.parts.annotations import AssembledBody, Assembly, Body
from pellucid.parts.capabilities import Membrane
from pellucid.step.part import AddedStiffness

FAILED = "failed"  # field of membranes that damage can tear


class Enclosure(NamedTuple):
    """An enclosed volume at one time. Areas and positions are listed by body, in the order of the point numbers. Failed
    points have zero area, since no pressure acts on a hole."""

    volume: float  # enclosed volume [m³]
    areas: list[np.ndarray]  # (n, 3) vector areas of the points of each body, pointing out of the volume [m²]
    places: list[np.ndarray]  # (n, 3) positions of the points of each body [m]
    failed: list[int]  # number of failed points of each body
    hole: float = 0.0  # area of the holes left by failed points in the outer membrane [m²]

    def swept(self, other: "Enclosure") -> float:
        """Return the volume [m³] that the membranes sweep between this state and the state `other`, without the volume swept
        by lids (flat covers over the rims of an open membrane)."""
        bodies = zip(self.areas, other.areas, self.places, other.places, strict=True)
        return sum(float(np.sum(0.5 * (area + later) * (there - place))) for area, later, place, there in bodies)


class EnclosedVolume:
    """Enclosed volume ⅓∮x·n dA over a membrane and the lids (flat covers) over the rims of an open membrane, minus the
    volumes of closed membranes inside it.

    The gradients of the volume with respect to the positions of the points are the vector areas on which the pressure
    acts, except at lids.
    """

    def __init__(self, outer: str, inside: Sequence[str], assembly: Assembly, channel: str) -> None:
        """outer: name of the membrane that encloses the volume; inside: names of closed membranes inside it; channel: name of
        the channel (entry of the energy balance) for the work of the pressure. Membranes may have inward or outward
        normals."""
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
        """The outer membrane, followed by the membranes inside it."""
        return [member.body for member in self.members]

    def now(self) -> Enclosure:
        """Return the present enclosed volume, the vector areas on which pressure acts, and the area of holes left by failed
        points."""
        volumes, areas, places = zip(*(self._of(number) for number in range(len(self.members))), strict=True)
        holes = [failed_points(body) for body in self.bodies]
        for area, failed in zip(areas, holes, strict=True):
            area[failed] = 0.0
        hole = float(self._membrane.surface_areas()[holes[0]].sum()) if len(holes[0]) else 0.0
        return Enclosure(sum(volumes), list(areas), list(places), [len(failed) for failed in holes], hole)

    @property
    def _membrane(self) -> Membrane:
        return self.members[0].offers(Membrane)

    @property
    def sign(self) -> float:
        """1 if the normals of the outer membrane point out of the volume, else -1."""
        return self._signs[0]

    def enclosed(self, places: np.ndarray, areas: np.ndarray) -> float:
        """Return the volume that the outer membrane encloses with points at other positions [m³].

        places: positions of the points [m]; areas: their vector areas along the normals of the membrane [m²], shape (n, 3)
        each, in the order of the point numbers.
        """
        return self._signs[0] * self._lids[0].volume(places, areas)

    def _of(self, number: int) -> tuple[float, np.ndarray, np.ndarray]:
        sign, member = self._signs[number], self.members[number]
        places = member.body.places()
        areas = member.offers(Membrane).pressed_areas()
        return sign * self._lids[number].volume(places, areas), sign * areas, places

    def press(self, now: Enclosure, pressure: float) -> None:
        """Apply a gauge pressure [Pa] to the membranes over this step; now: present state of the enclosed volume."""
        for body, add, areas in zip(self.bodies, self._add, now.areas, strict=True):
            add((pressure * areas)[body.stored_array("id")])

    def membrane_area(self) -> float:
        """Return the area of the outer membrane, including the holes left by failed points [m²]."""
        return float(self._membrane.surface_areas().sum())

    def mobility(self, now: Enclosure) -> float:
        """Return the second time derivative of the volume per unit pressure, Σ A²/m [m⁴/kg], with vector area A and mass m of
        each point, if the membranes carry no other mass; now: present state of the enclosed volume."""
        masses = [np.asarray(body.field("mass")) for body in self.bodies]
        return sum(float(np.sum(np.sum(a * a, axis=1) / m)) for a, m in zip(now.areas, masses, strict=True))

    def growth(self, now: Enclosure) -> float:
        """Return the rate of change of the enclosed volume due to the velocities of the points [m³/s]; now: present state of
        the enclosed volume."""
        velocities = [np.asarray(body.field("velocity")) for body in self.bodies]
        return sum(float(np.sum(a * v)) for a, v in zip(now.areas, velocities, strict=True))

    def added_stiffness(self, rate: float, contents: str) -> AddedStiffness:
        """Return the stiffness that the oscillation of the enclosed volume adds to the membranes.

        rate: half the angular frequency of the volume [1/s]; contents: what the membranes oscillate on, for messages.
        """
        totals = [body.totals for body in self.bodies]
        return AddedStiffness(totals, rate, "spring", f"membrane `{self.bodies[0].name}` oscillates on {contents}")


def failed_points(body: Body) -> np.ndarray:
    """Return the numbers of the failed points of a membrane, which carry no stress, shape (k,)."""
    if FAILED not in body.field_names:
        return np.zeros(0, np.int64)
    return np.flatnonzero(np.asarray(body.field(FAILED)) > 0.0)
