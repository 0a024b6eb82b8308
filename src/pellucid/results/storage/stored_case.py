"""The part of a case that results need. It can be read even if kinds that the case names are no longer registered."""

import tomllib
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pydantic import BaseModel, ConfigDict

from pellucid.case import EnergyCase, OutputCase, TimeCase
from pellucid.case.judgement import Check
from pellucid.case.picture import Film, Picture
from pellucid.case.plot import Plot
from pellucid.case.stages import SteadyCase
from pellucid.grid.model import GridCase
from pellucid.results.readings import mean_columns


class StoredBody(NamedTuple):
    """Data of a body that readers of results need: its name, kind, kinds of material and equation of state (empty if none),
    and density [kg/m³], or the surface density [kg/m²] of a fluid film."""

    name: str
    kind: str
    material: str
    equation_of_state: str
    density: float
    thickness: float | None = None
    """Thickness of a membrane [m]."""
    contact_offset: float | None = None
    """Distance from the mid-surface of a membrane at which other bodies are in contact with it [m]."""


class StoredWall(NamedTuple):
    """A plane wall of the case, for pictures: its name, a point on the plane at time 0 [m], the unit normal towards the
    bodies, and the velocity of the plane [m/s], each vector of shape (3,)."""

    name: str
    point: np.ndarray
    normal: np.ndarray
    velocity: np.ndarray

    def level(self, time: float) -> float:
        """Return the signed distance of the plane from the origin along its normal [m] at a time [s]."""
        return float(self.normal @ (self.point + time * self.velocity))


SHOWN = ("body", "probe", "picture", "film", "plot", "check", "extensions")
"""Lists of a case that the report shows separately."""


class StoredCase(BaseModel):
    """The part of a case that readers of results need. Kinds (of bodies and materials) are stored as texts, because users
    may define kinds that are not available when results are read."""

    model_config = ConfigDict(arbitrary_types_allowed=True)

    title: str
    id: str = ""
    source: str = ""
    description: str = ""
    extensions: tuple[str, ...] = ()
    grid: GridCase | None = None
    time: TimeCase
    steady: SteadyCase | None = None
    output: OutputCase = OutputCase()
    energy: EnergyCase = EnergyCase()
    bodies: tuple[StoredBody, ...]
    probes: tuple[str, ...]
    """Names of the probes."""
    means: tuple[str, ...] = ()
    """Names of the probes whose values are means since the previous row, see `pellucid.results.readings`."""
    walls: tuple[StoredWall, ...] = ()
    others: dict[str, int] = {}
    """Number of entries of the other tables, such as supports, by key."""
    picture: tuple[Picture, ...] = ()
    film: tuple[Film, ...] = ()
    plot: tuple[Plot, ...] = ()
    check: tuple[Check, ...] = ()

    @property
    def thin(self) -> tuple[bool, bool, bool]:
        """Mask of the axes along which the grid is one cell thick; all False without a grid."""
        return (False, False, False) if self.grid is None else self.grid.thin()


def read(path: Path) -> StoredCase:
    """Read the case file of a run. Raises KeyError or ValueError for another file."""
    data = tomllib.loads(path.read_text(encoding="utf-8"))
    bodies = [_body(table) for table in data["body"]]
    lists = {key: tables for key, tables in data.items() if isinstance(tables, list) and key not in SHOWN and tables}
    others = {key: len(tables) for key, tables in lists.items() if isinstance(tables[0], dict)}
    quantities = {probe["name"]: str(probe.get("quantity", "")) for probe in data.get("probe", ())}
    own = {"bodies": bodies, "probes": list(quantities), "others": others}
    own["walls"] = [_wall(table, number) for number, table in enumerate(data.get("wall", ()))]
    own["means"] = mean_columns(quantities.items(), "steady" in data)
    return StoredCase.model_validate({**data, **own})


def _body(table: dict[str, Any]) -> StoredBody:
    material = table["material"]
    law = material["eos"]["kind"] if "eos" in material else ""
    thickness = table.get("thickness")
    offset = table.get("contact_offset", None if thickness is None else 0.5 * thickness)
    return StoredBody(table["name"], table["kind"], material["kind"], law, material["density"], thickness, offset)


def _wall(table: dict[str, Any], number: int) -> StoredWall:
    normal = np.array(table["normal"], float)
    normal /= np.abs(normal).max()  # so that no square of a component overflows or vanishes
    velocity = np.array(table.get("velocity", (0.0, 0.0, 0.0)), float)
    name = f"wall {table.get('name', number + 1)}"
    return StoredWall(name, np.array(table["point"], float), normal / np.linalg.norm(normal), velocity)
