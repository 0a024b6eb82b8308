"""Messages about solids and membranes that are in contact on the nodes of the grid, with remedies."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from pellucid.contact.pairs import ContactPairs
from pellucid.findings import listed
from pellucid.parts.body_model import BodyModel
from pellucid.simulation.assembly import Built
from pellucid.simulation.contacts import has_surface

if TYPE_CHECKING:
    from pellucid.case import Case


def node_contacts(case: "Case", built: Built, pairs: ContactPairs) -> list[str]:
    """Return a message for each pair of velocity fields with solids or membranes that are in contact on the nodes of the grid.

    Contact of fluids is not reported, since fluids are always in contact on the nodes. built: all bodies, by name; pairs:
    the contacts on nodes.
    """
    lines = []
    for fields in pairs.fields():
        members = [[model for model in case.body if built[model.name][1] is field] for field in fields]
        sides = [[model for model in models if not model.is_fluid] for models in members]
        if all(sides):
            names = " and ".join(listed([model.name for model in side]) for side in sides)
            reason, remedy = _explain(members, built)
            lines.append(
                f"contact: {names} touch on the nodes of the grid, since {reason}: bodies that slide or roll there lose "
                f"some per cent of their speed; {remedy}"
            )
    return lines


def _explain(members: Sequence[Sequence[BodyModel]], built: Built) -> tuple[str, str]:
    """Return the reason why the bodies of two velocity fields are in contact on the grid nodes and not by surfaces, and a
    remedy.

    members: models of the bodies of each field; built: all bodies, by name.
    """
    for models in members:
        for model in models:
            if not model.is_fluid and not has_surface(built[model.name][0]):
                return f'body {model.name}, of kind "{model.kind}", has no contact surface', model.remedy_for_node_contact
    for models in members:
        solids, fluids = ([model for model in models if model.is_fluid is wanted] for wanted in (False, True))
        if fluids and solids:
            inner, outer = (listed([model.name for model in some]) for some in (solids, fluids))
            return (
                f"the velocity field of {inner} also contains the fluid outside of it ({outer})",
                "use another `field` for the fluid outside, or a smaller grid.cell",
            )
    return "two membranes of these kinds have no common contact", "use membranes of elements for both, or a smaller grid.cell"
