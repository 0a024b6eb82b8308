"""Write the table of nodal fields into docs/reference/nodal-arrays.md. Run it after a change of their declarations."""

from pathlib import Path
from typing import Any

from pellucid.conditions.enclosed.active import PressedNodes
from pellucid.conditions.nodal_fluid import FluidSums
from pellucid.conditions.open_faces.pressure_face import EndNodes
from pellucid.conditions.pressure_on_walls import WalledNodes
from pellucid.conditions.rigid.nodes import BodySums
from pellucid.conditions.surface_tension.colour import SurfaceFields
from pellucid.contact.detection import NumberedNodes, SharedNodes
from pellucid.grid.consistent_mass import MappedNodes
from pellucid.grid.even_points import EvenCells
from pellucid.grid.lattice import NodeFlags, Nodes
from pellucid.grid.momentum import AdvancedNodes
from pellucid.grid.nodal_conditions import ExternalAction, YieldingWalls
from pellucid.grid.nodal_fields import FOUND, REMAP, RUN, STEP, NodalField, declared
from pellucid.grid.points import FullCells
from pellucid.grid.second_increments import SecondNodes
from pellucid.grid.velocity_field import FieldNodes
from pellucid.grid.viscous_rows import ViscousRows

PAGE = Path(__file__).parent / "reference" / "nodal-arrays.md"
BEGIN, END = "<!-- Written by docs/nodal_field_table.py. -->\n", "<!-- To here. -->"
SETS: dict[type[Any], str] = {
    Nodes: "of every velocity field",
    FieldNodes: "of some",
    SecondNodes: "",
    ExternalAction: "of what acts on the nodes",
    AdvancedNodes: "",
    YieldingWalls: "of walls that rub or open",
    MappedNodes: "of the consistent mass matrix",
    NodeFlags: "by which nodes are listed",
    ViscousRows: "of implicit viscosity",
    SurfaceFields: "of a fluid with surface tension",
    EndNodes: "of a fluid that leaves or comes in under a pressure",
    FullCells: "of cells, by their first nodes",
    EvenCells: "",
    BodySums: "of a rigid body on the grid",
    FluidSums: "of fluids beside walls at the shapes of supports",
    WalledNodes: "",
    PressedNodes: "of a membrane with contents in liquids with implicit pressure",
    SharedNodes: "of two velocity fields in contact",
    NumberedNodes: "of the nodes that they share",
}
"""Sets of nodal arrays that declare fields, each with a heading of the table; the heading is empty for a set that continues
the previous one."""
CLEARED = {STEP: "each step", REMAP: "before momentum is mapped again", RUN: "-"}


def table() -> str:
    """Return the table, with a row for each nodal field and for each view of some of its components."""
    head = "| field | numbers | unit | contributions | cleared | what |\n|---|---|---|---|---|---|\n"
    lines = []
    for kind, whose in SETS.items():
        lines += [f"| *{whose}* | | | | | |"] if whose else []
        for name, one in declared(kind).items():
            if isinstance(one, NodalField):
                combine = one.combine if isinstance(one.combine, tuple) else (one.combine,)
                how = ", ".join("-" if each == FOUND else each for each in combine)
                lines.append(f"| `{name}` | {one.components} | {one.unit} | {how} | {CLEARED[one.cleared]} | {one.meaning} |")
            else:
                cleared = CLEARED[one.cleared] if one.cleared else ""
                numbers = "3" if isinstance(one.part, slice) else "1"
                lines.append(f"| `{name}` | {numbers} of `{one.of}` | {one.unit} | | {cleared} | {one.meaning} |")
    return head + "\n".join(lines) + "\n"


def page() -> str:
    """Return the text of the page with a new table."""
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    return before + BEGIN + table() + END + rest.partition(END)[2]


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
