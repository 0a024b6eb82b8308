"""The parts (tables) of a case, found from its data model: the keys that hold tables, the class of these tables, and
whether a key holds a list."""

from collections.abc import Mapping
from functools import cache
from types import UnionType
from typing import Annotated, Any, NamedTuple, Union, get_args, get_origin

from pydantic import BaseModel, TypeAdapter, ValidationError

from pellucid.model import Model
from pellucid.parts.part import Parts, Section


class Place(NamedTuple):
    """A key of a case file that holds one table or a list of tables: attribute of the case class with the table or tables,
    class of a table (`base`), its pydantic validator (`adapter`), and whether the key holds a list."""

    attribute: str
    base: type[Model]
    adapter: TypeAdapter[Any]
    is_list: bool
    is_optional: bool
    """True if the table is optional."""


@cache
def places(case: type[BaseModel]) -> dict[str, Place]:
    """Return the keys of a case file that hold tables with their own class, each with a description (`Place`). case: class
    of the case."""
    found = {}
    for attribute, field in case.model_fields.items():
        item = field.annotation
        is_list = get_origin(item) is tuple and get_args(item)[-1] is ...
        is_optional = field.default is None
        item = get_args(item)[0] if is_list else _without_none(item)
        base = get_args(item)[0] if get_origin(item) is Annotated else item
        if isinstance(base, type) and issubclass(base, Model):
            found[field.alias or attribute] = Place(attribute, base, TypeAdapter(item), is_list, is_optional)
    return found


def parts_of(case: BaseModel) -> Parts:
    """Return the parts (tables) of a valid case by class, see `Parts`."""
    sections = {}
    for key, place in places(type(case)).items():
        value = getattr(case, place.attribute)
        one = [] if value is None else [value]
        sections[key] = Section(place.base, value if place.is_list else one, place.is_list, value is not None)
    return Parts(sections, getattr(case, "gravity", None))


def parts_in(case: type[BaseModel], data: Mapping[str, Any]) -> Parts:
    """Return the parts (tables) of the data of a case, which may contain invalid tables; an invalid table is represented by
    its name, or by None if the table has no name. case: class of the case."""
    sections = {}
    for key, place in places(case).items():
        if place.is_list:
            # an invalid value may contain a part that another part names
            written = data.get(key, [])
            items = [_sound(item, place) for item in written] if isinstance(written, list) else [None]
        elif place.is_optional and data.get(key) is None:
            items = []
        else:
            items = [_sound(data.get(key, {}), place)]
        sections[key] = Section(place.base, items, place.is_list, key in data)
    return Parts(sections)


def _sound(item: Any, place: Place) -> Model | str | None:
    try:
        sound: Model = place.adapter.validate_python(item)
    except ValidationError:
        name = item.get("name") if isinstance(item, dict) else None
        return name if isinstance(name, str) else None
    return sound


def _without_none(annotation: Any) -> Any:
    if get_origin(annotation) in (Union, UnionType):
        options = [option for option in get_args(annotation) if option is not type(None)]
        return options[0] if len(options) == 1 else None
    return annotation
