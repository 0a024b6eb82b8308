"""Data models of inflators and vents of enclosed gases and liquids; enclosed volume and mobility of closed membranes, computed
from their data models before the bodies are built; and the checks of a case with enclosed gas or liquid that need them."""

from collections.abc import Iterator
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from pellucid.bodies.membranes.model import MembraneCase
from pellucid.conditions.signals.time_table import check_order, read_rows
from pellucid.findings import Finding, Path, listed
from pellucid.geometry.meshes.cells import corner_areas, vector_areas
from pellucid.geometry.meshes.enclosure import BENT, Lids, volume_with_lids
from pellucid.model import InputFile, Model, check, parameter
from pellucid.parts.body_model import BodyModel
from pellucid.parts.part import Parts


class Inflator(Model):
    """Inflow over time: linear between given times, zero before the first and after the last."""

    times: tuple[float, ...] | None = parameter("s", "times of the table, in increasing order", None, min_length=2)
    mass_flows: tuple[float, ...] | None = parameter("kg/s", "mass inflow rate at each time", None)
    temperatures: tuple[float, ...] | None = parameter("K", "temperature of the inflowing gas at each time", None)
    path: InputFile | None = parameter(
        "",
        "alternative: a CSV file with the columns time [s], mass flow [kg/s] and, for a gas, temperature [K]; a header row "
        "is allowed",
        None,
    )

    @check
    def _is_a_function(self) -> None:
        if (self.path is None) == (self.times is None) or (self.times is None) != (self.mass_flows is None):
            raise ValueError("give either `times`, `mass_flows` and, for a gas, `temperatures`, or `path`")
        lists = [values for values in (self.times, self.mass_flows, self.temperatures) if values is not None]
        if len({len(values) for values in lists}) > 1:
            numbers = listed([str(len(values)) for values in lists])
            raise ValueError(f"{numbers} times, mass flows and temperatures; give the same number of each")
        check_order(self.times or ())
        if min(self._rows[1]) < 0.0:
            raise ValueError(f"mass flow {min(self._rows[1]):g} kg/s: an inflator cannot have outflow; use a vent")
        if self._rows[2] and min(self._rows[2]) <= 0.0:
            raise ValueError(f"temperature {min(self._rows[2]):g} K must be above 0; give kelvins")

    @cached_property
    def _rows(self) -> tuple[tuple[float, ...], ...]:
        """Times [s], mass flow rates [kg/s] and temperatures [K] (empty if not given)."""
        if self.path is not None:
            rows = read_rows(self.path, "mass flow [kg/s]", "temperature [K]").T.tolist()
            return tuple(map(tuple, (*rows, ()) if len(rows) == 2 else rows))
        return self.times or (), self.mass_flows or (), self.temperatures or ()

    @property
    def has_temperatures(self) -> bool:
        """True if the temperatures of the inflowing gas are given."""
        return len(self._rows[2]) > 0

    def given(self, start: float, end: float) -> tuple[float, float]:
        """Return the mass of the inflow between the times `start` and `end` [s], in kg, and the integral ∫T dm of its
        temperature T over its mass m [K kg] (0 if no temperatures are given), both integrated exactly."""
        times, flows, temperatures = self._rows
        inner = [time for time in times if start < time < end]
        mass = warmth = 0.0
        for first, last in pairwise([start, *inner, end]):
            if first < times[0] or last > times[-1] or last <= first:
                continue
            instants = (first, 0.5 * (first + last), last)
            flow = np.interp(instants, times, flows)
            warm = np.interp(instants, times, temperatures) if temperatures else np.zeros(3)
            weights = (last - first) / 6.0 * np.array((1.0, 4.0, 1.0))  # Simpson's rule, exact for cubics
            mass += float(np.sum(weights * flow))
            warmth += float(np.sum(weights * flow * warm))
        return mass, warmth


class Vent(Model):
    """An opening through which gas or liquid flows out against the outside pressure."""

    area: float = parameter("m^2", "area A of the opening", gt=0)
    coefficient: float = parameter("", "discharge coefficient: factor on the area A", 1.0, gt=0, le=1)
    opens_at: float = parameter(
        "Pa",
        "gauge pressure inside at which the vent opens permanently; default: open from the start",
        0.0,
        ge=0,
    )


FLAT = 1e-9  # largest volume of a flat membrane, relative to the cube of its extent


def encloses_problems(
    name: str, lids: bool, path: Path, parts: Parts, allows_flat: bool, at: Path | None = None
) -> Iterator[Finding]:
    """Yield findings if a body named `name` encloses no volume, for a condition that needs this volume.

    lids: True if flat lids close the rims of an open membrane; path: path of the condition in the case; parts: all parts of
    the case; allows_flat: True if the membrane may be flat at the start; at: path of the key that names the body, if it is
    not `body`.

    """
    here = at or (*path, "body")
    yield from parts.unknown(BodyModel, here, name)
    body = parts.named(BodyModel, name)
    if body is None:
        return
    start = body.selectable() if body.is_surface and not body.evaluates_loads else None
    if start is None:
        text = f'body {name} is of kind "{body.kind}", which has no enclosed volume'
        yield Finding(here, text, "name a body of kind membrane-elements or membrane-points")
    elif not all(parts.active_axes):
        text = f"body {name} is a membrane in a plane problem, which has no volume"
        yield Finding(here, text, "use a grid that is more than one cell thick along every axis")
    elif len(start.boundary) and not lids:
        text = f"the surface of body {name} is open: it encloses no volume"
        closes = "" if at else ", or close its rims with lids: `lids = true`"
        yield Finding(here, text, f"use a closed surface{closes}")
    elif lids and not len(start.boundary):
        yield Finding((*path, "lids"), f"the surface of body {name} is closed: it has no rim", "remove `lids`")
    elif lids and (bend := Lids(start.position, start.faces).bend) > BENT:
        text = (
            f"a rim of body {name} is bent: its points lie {100 * bend:.2g} % of its extent off a plane, so a lid "
            "would not be flat"
        )
        yield Finding(
            (*path, "lids"),
            text,
            f"make each rim flat, within {100 * BENT:g} % of its extent, or let it lie on planes of symmetry",
        )
    elif not allows_flat and is_flat(start.position, start.faces):
        text = f"body {name} is flat at the start: it encloses no volume"
        yield Finding(here, text, "use a surface that encloses a volume at the start")


def volume_at_start(position: np.ndarray, triangles: np.ndarray) -> float:
    """Return the volume enclosed by triangles and the lids over their rims [m³], for either orientation of the normals.
    position: vertices [m], shape (n, 3); triangles: vertex numbers, shape (m, 3)."""
    return abs(volume_with_lids(position, triangles))


def is_flat(position: np.ndarray, triangles: np.ndarray) -> bool:
    """Return True if the volume enclosed by triangles and the lids over their rims is zero up to rounding. position:
    vertices [m], shape (n, 3); triangles: vertex numbers, shape (m, 3)."""
    return volume_at_start(position, triangles) <= FLAT * float(np.ptp(position, axis=0).max()) ** 3


class AtStart(NamedTuple):
    """State of a membrane at the start, from which the stable step of an enclosed volume is estimated before the run."""

    volume: float  # enclosed volume [m³]
    mobility: float  # second time derivative of the volume per unit of gauge pressure [m⁴/kg]: Σ A²/m over the nodes,
    # with the vector area A and the mass m of a node


def membrane_at_start(body: BodyModel) -> AtStart | None:
    """Return the enclosed volume of a membrane at the start [m³], and the acceleration of this volume per unit of gauge
    pressure [m⁴/kg]; None for other bodies, or if no volume is enclosed."""
    if not isinstance(body, MembraneCase):
        return None
    vertices, triangles = body.surface.triangulate()
    thirds = np.linalg.norm(vector_areas(vertices, triangles), axis=1) / 3.0
    sizes = np.bincount(triangles.ravel(), np.repeat(thirds, 3), len(vertices))
    mass = body.material.density * body.thickness * sizes
    volume = volume_at_start(vertices, triangles)
    if volume <= 0.0:
        return None
    return AtStart(volume, float(np.sum(np.square(corner_areas(vertices, triangles)) / mass[:, None])))
