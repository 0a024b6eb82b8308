"""Registered kinds, of the package or of users, are known to case files, the schema and the messages."""

from collections.abc import Iterator
from typing import Annotated, Literal

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError
from registries import forgotten_afterwards

from pellucid.bodies.initial import INITIAL_FIELDS, InitialField
from pellucid.bodies.models import BODIES
from pellucid.case import json_schema
from pellucid.case.schema import schema_of
from pellucid.conditions.loads import LOADS
from pellucid.conditions.signals import SIGNALS, TURNS
from pellucid.materials import MATERIALS, MEMBRANE_MATERIALS, Material
from pellucid.materials.eos import EQUATIONS_OF_STATE
from pellucid.model import Model, parameter
from pellucid.registry import Family, OneNameOf, OneOf, Registry, register


@pytest.fixture(autouse=True)
def _nothing_stays() -> Iterator[None]:
    with forgotten_afterwards():
        yield


class Uniform(InitialField):
    kind: Literal["uniform"] = "uniform"
    speed: float = parameter("m/s", "how fast", 1.0, ge=0)

    def at(self, position: np.ndarray) -> np.ndarray:
        return np.full_like(position, self.speed)


class Holder(Model):
    field: Annotated[InitialField, OneOf(INITIAL_FIELDS)]


@pytest.mark.parametrize(
    "family", [BODIES, MATERIALS, MEMBRANE_MATERIALS, EQUATIONS_OF_STATE, INITIAL_FIELDS, LOADS, SIGNALS, TURNS]
)
def test_each_of_the_package_is_registered_under_its_own_kind(family: Family) -> None:
    assert family.entries
    for kind, model in family.entries.items():
        assert issubclass(model, family.base)
        assert model.model_fields["kind"].default == kind


def test_what_is_registered_can_be_named_at_once() -> None:
    with pytest.raises(ValidationError, match="'sine-wave'"):
        Holder(field={"kind": "uniform"})
    assert register(Uniform) is Uniform
    found = Holder(field={"kind": "uniform", "speed": "2 km/s"}).field
    assert found == Uniform(speed=2000.0)
    assert Holder(field=found).field is found
    assert Holder(field=found).model_dump() == {"field": {"kind": "uniform", "speed": 2000.0}}


def test_an_object_of_a_kind_that_no_file_could_name_is_refused() -> None:
    with pytest.raises(ValidationError, match="Uniform is not registered: decorate its class with `@register`"):
        Holder(field=Uniform())


def test_mistakes_in_a_registered_table_are_found_where_they_stand() -> None:
    register(Uniform)
    with pytest.raises(ValidationError) as caught:
        Holder(field={"kind": "uniform", "speed": -1.0})
    (error,) = caught.value.errors()
    assert (error["loc"], error["type"]) == (("field", "speed"), "greater_than_equal")
    for value, kind in (({"speed": 1.0}, "union_tag_not_found"), (3, "model_type"), ({"kind": 3}, "union_tag_invalid")):
        with pytest.raises(ValidationError) as caught:
            Holder(field=value)
        assert caught.value.errors()[0]["type"] == kind
        assert caught.value.errors()[0]["loc"] == ("field",)


def test_the_schema_knows_what_is_registered_at_the_moment() -> None:
    before = json_schema()
    assert "Uniform" not in before["$defs"]
    register(Uniform)
    after = json_schema()
    assert after["$defs"]["Uniform"]["properties"]["speed"]["unit"] == "m/s"
    items = after["$defs"]["MaterialPointsCase"]["properties"]["initial"]["items"]
    assert items["oneOf"][0] == {"$ref": "#/$defs/SineWave"}
    assert items["oneOf"][-1] == {"$ref": "#/$defs/Uniform"}
    kinds = schema_of(Holder).kinds(schema_of(Holder).field_at(("field",), {}))
    assert kinds == list(INITIAL_FIELDS.entries)
    assert kinds[-1] == "uniform"


def test_a_default_kind_may_be_left_out() -> None:
    family = Family("thing", Model, default="a")

    class A(Model):
        kind: Literal["a"] = "a"

    family.add(A)
    Registry.every.remove(family)
    assert TypeAdapter(Annotated[Model, OneOf(family)]).validate_python({}) == A()


def test_a_kind_cannot_be_taken_twice() -> None:
    register(Uniform)

    class Other(Uniform):
        pass

    with pytest.raises(
        ValueError, match=r"already registered by `Uniform` in .*test_registry.py: choose another name for `.*Other` in"
    ):
        register(Other)


def test_the_type_of_a_kind_is_its_default() -> None:
    class Renamed(Uniform):
        kind: Literal["steady"] = "uniform"  # type: ignore[assignment]

    with pytest.raises(TypeError, match=r'Renamed.kind is "steady" by its type and "uniform" by default: write `kind: Lit'):
        register(Renamed)


def test_a_class_may_be_defined_anew_as_in_a_notebook() -> None:
    def define() -> type[InitialField]:
        class Again(InitialField):
            kind: Literal["again"] = "again"

            def at(self, position: np.ndarray) -> np.ndarray:
                return position

        return Again

    register(define())
    latest = register(define())
    assert INITIAL_FIELDS.entries["again"] is latest


def test_a_class_that_is_no_kind_of_anything_is_refused() -> None:
    class Nothing(Model):
        kind: Literal["nothing"] = "nothing"

    with pytest.raises(TypeError, match=r"Nothing derives from no base class .* derive it from one of .*InitialField"):
        register(Nothing)

    class Nameless(InitialField):
        def at(self, position: np.ndarray) -> np.ndarray:
            return position

    with pytest.raises(TypeError, match=r'Nameless has no kind: add the field `kind: Literal\["my-kind"\] = "my-kind"`'):
        register(Nameless)


def test_a_field_holds_one_of_a_registry_s_names() -> None:
    registry: Registry[int] = Registry("number")
    Registry.every.remove(registry)
    adapter = TypeAdapter(Annotated[str, OneNameOf(registry.entries, "many")])
    registry.register("one", 1, test_a_field_holds_one_of_a_registry_s_names)
    assert adapter.validate_python("one") == "one"
    assert adapter.json_schema() == {"type": "string", "enum": ["one", "many"]}
    with pytest.raises(ValidationError, match="'one', 'many'"):
        adapter.validate_python("two")


def test_materials_are_told_apart_by_their_kind() -> None:
    table = {"kind": "neo-hookean", "density": 1.0, "young_modulus": 1.0, "poisson_ratio": 0.0}
    assert TypeAdapter(Material).validate_python(table) == MATERIALS.entries["neo-hookean"](**table)
