"""What bodies offer beside what all do: by the classes that kinds derive from, or by having the methods."""

from types import FunctionType, SimpleNamespace
from typing import ClassVar

import pytest
from registries import forgotten_afterwards

from pellucid.bodies.diffusing_field.body import DiffusingField
from pellucid.bodies.diffusing_field.model import DiffusingFieldCase
from pellucid.bodies.fluid_film.body import FluidFilm
from pellucid.bodies.fluid_film.on_grid import FilmOnGrid
from pellucid.bodies.material_points.body import MaterialPoints
from pellucid.bodies.material_points.surface import TakesForces
from pellucid.bodies.membrane_elements.on_grid import ElementsOnGrid
from pellucid.bodies.membrane_elements.on_own_nodes import MembraneElements
from pellucid.bodies.membrane_points.body import MembranePoints
from pellucid.bodies.meshless_solid.body import MeshlessSolid
from pellucid.contact import contact_body
from pellucid.parts import capabilities
from pellucid.parts.assembly import AssembledBody
from pellucid.parts.capabilities import TakesDrag, TakesGravity
from pellucid.parts.constraint import ConstrainedPoints
from pellucid.state import FIELDS, Field

ON_GRID = {"TakesExternalForces", "TakesDrag", "TakesSecondImpulses"}
OWN_NODES = ON_GRID | {"TakesGravity", "TakesSupports", "ReleasesSupports", "TakesMotions", "Relaxable", "BoundByContact"}
MEMBRANE = {"Membrane", "TakesPressure"}
FILM = {"Membrane", "TakesTractions"}
OFFERED = {
    MaterialPoints: ON_GRID
    | {"HasContactSurface", "BoundByContact", "HasPointsAtWalls", "LosesPoints", "GainsPoints", "KeepsHeat", "WarnsOfApproach"},
    MembranePoints: ON_GRID | MEMBRANE,
    ElementsOnGrid: ON_GRID | MEMBRANE | {"WarnsOfContact", "HasContactSurface", "BoundByContact"},
    FilmOnGrid: ON_GRID | FILM | {"HasContactSurface", "BoundByContact"},
    MembraneElements: OWN_NODES | MEMBRANE | {"WarnsOfContact", "HasContactSurface", "BoundByContact"},
    MeshlessSolid: OWN_NODES | {"HasMesh", "HasContactSurface", "BoundByContact"},
    FluidFilm: FILM | {"TakesExternalForces", "TakesGravity", "TakesSupports", "TakesNormalMotions", "ShowsStart"},
    DiffusingField: set(),
}
ASKED_FOR = {
    name: asked
    for module in (capabilities, contact_body)
    for name, asked in vars(module).items()
    if getattr(asked, "_is_runtime_protocol", False) and asked.__module__ == module.__name__
}


@pytest.mark.parametrize("kind", OFFERED, ids=lambda kind: kind.__name__)
def test_kinds_offer_what_they_are_to(kind):
    assert {name for name, asked in ASKED_FOR.items() if asked in kind.__mro__} == OFFERED[kind]


def test_methods_alone_make_a_capability():
    body = SimpleNamespace(name="own", damp=lambda rate, dt: (0.0, 0.0))
    member = AssembledBody(body, None, None)
    assert member.offers(TakesDrag) is body
    with pytest.raises(ValueError, match="body own lacks the capability `TakesGravity`"):
        member.offers(TakesGravity)


@pytest.mark.parametrize("asked", [*ASKED_FOR.values(), TakesForces], ids=lambda asked: asked.__name__)
def test_the_test_for_a_capability_evaluates_no_property(asked):
    """Before Python 3.12 `isinstance` evaluates the data members of a protocol, even for its subclasses."""
    assert not any(vars(each).get("__annotations__") for each in asked.__mro__)
    members = {name: what for name, what in vars(asked).items() if not name.startswith("_")}
    assert members
    assert all(isinstance(what, FunctionType) for what in members.values())


def test_the_test_for_a_constraint_evaluates_no_property():
    class Leading(SimpleNamespace):
        @property
        def strains(self):
            raise RuntimeError

        own_spin = rows = top_speed = own_energy = mixing = prescribe_velocities_again = strains

    body = ConstrainedPoints()
    body.constrain(Leading())
    assert (body.rigid, body.takes_second_impulses()) == (None, False)


def test_a_kind_declares_fields_that_no_other_has():
    with forgotten_afterwards():

        class Salty(DiffusingFieldCase):
            fields: ClassVar = {"salinity": Field(1, "1", "salt by mass")}

        assert FIELDS["salinity"].meaning == "salt by mass"
        with pytest.raises(TypeError, match=r"Other.salinity: a field of this name exists \(salt by mass\); choose another"):

            class Other(DiffusingFieldCase):
                fields: ClassVar = {"salinity": Field(1, "kg/m^3", "salt by volume")}

    assert "salinity" not in FIELDS
