"""The kinds that case files can name: kinds of the package and of users, registered in the same way.

A `Family` is a set of models selected by their `kind`, a `Registry` a set of functions selected by name. Both are read when
a case is read, so that kinds registered later are included.
"""

from collections.abc import Mapping
from typing import Any, ClassVar, Generic, Literal, TypeVar, cast, get_args, get_origin

from pydantic import BaseModel, GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationError
from pydantic_core import CoreSchema, PydanticKnownError, core_schema

from pellucid.findings import listed
from pellucid.users.users_code import failure, file_of, is_own

ModelType = TypeVar("ModelType", bound=BaseModel)
EntryType = TypeVar("EntryType")


class Registry(Generic[EntryType]):
    """Functions or classes that a case can name, such as the kinds of loads: `entries` is the dictionary by name, and
    `register` adds an entry. Each name can be registered by one source only.

    what: word for an entry in messages, such as "load".
    """

    every: ClassVar["list[Registry[Any]]"] = []  # all registries of the program
    changes: ClassVar[int] = 0
    """Number of registrations in all registries; data derived from entries are out of date if it has changed."""

    def __init__(self, what: str) -> None:
        self.what = what
        self.entries: dict[str, EntryType] = {}
        Registry.every.append(self)

    def register(self, name: str, entry: EntryType, source: Any) -> None:
        """Register an entry under a name; source: class or function that defines the entry.

        If the file of a source is read again, the new entry replaces the old one. Raises ValueError if another source has
        registered this name.
        """
        before = self.entries.get(name)
        if before is not None and _home(before) != _home(source):
            text = f'the {self.what} "{name}" is already registered by {_described(before)}'
            raise ValueError(f"{text}: choose another name for {_described(source)}")
        self.entries[name] = entry
        Registry.changes += 1


class Family(Registry[type[ModelType]]):
    """The kinds of a table, such as the materials: subclasses of one base class, selected by the key `kind`.

    default: the kind of a table without the key; without a default the key is required.
    """

    def __init__(self, what: str, base: type[ModelType], default: str = "") -> None:
        super().__init__(what)
        self.base, self.default = base, default

    def add(self, model: type[ModelType]) -> None:
        """Register a model (a subclass of the base class) under its `kind`. Raises TypeError for a model without a kind or with
        missing methods, ValueError for a kind that is already registered."""
        field = model.model_fields.get("kind")
        if (
            field is None
            or get_origin(field.annotation) is not Literal
            or not isinstance(field.default, str)
            or not field.default
        ):
            raise TypeError(f'{model.__name__} has no kind: add the field `kind: Literal["my-kind"] = "my-kind"`')
        if get_args(field.annotation) != (field.default,):
            allowed = " or ".join(f'"{kind}"' for kind in get_args(field.annotation))
            text = f'{model.__name__}.kind is {allowed} by its type and "{field.default}" by default'
            raise TypeError(f'{text}: write `kind: Literal["{field.default}"] = "{field.default}"` or correct both')
        if lacking := sorted(model.__abstractmethods__):
            methods = listed([f"`{name}`" for name in lacking])
            raise TypeError(
                f"{model.__name__} does not define {methods}: every {self.what} must define these methods; add them"
            )
        self.register(field.default, model, model)

    def kinds_of(self, base: type[BaseModel]) -> dict[str, type[ModelType]]:
        """Return the registered models that derive from a base class, by kind."""
        return {kind: model for kind, model in self.entries.items() if issubclass(model, base)}

    def validated(self, value: Any, base: type[BaseModel] | None = None) -> ModelType:
        """Return the model of a table in a case, of the kind that the table names, which must derive from `base`; value: the
        table."""
        entries = self.kinds_of(base or self.base)
        if isinstance(value, self.base) and isinstance(value, base or self.base):
            if getattr(value, "kind", None) not in self.entries:
                raise ValueError(f"{type(value).__name__} is not registered: decorate its class with `@register`")
            return value
        if not isinstance(value, Mapping):
            raise PydanticKnownError("model_type", {"class_name": (base or self.base).__name__})
        kind = value.get("kind", self.default)
        if not kind:
            raise PydanticKnownError("union_tag_not_found", {"discriminator": "kind"})
        model = entries.get(kind) if isinstance(kind, str) else None
        if model is None:
            tags = ", ".join(f"'{name}'" for name in entries)
            raise PydanticKnownError("union_tag_invalid", {"discriminator": "kind", "tag": str(kind), "expected_tags": tags})
        try:
            return model.model_validate(value)
        except ValidationError:
            raise
        except Exception as error:  # of a user's kind: pydantic lets all but ValueError and AssertionError pass
            raise ValueError(f'the class of the {self.what} of kind "{kind}" raised an error: {failure(error)}') from error


class OneOf:
    """Annotation of a field with a table of any kind of a family: `Annotated[Base, OneOf(FAMILY)]`.

    base: only kinds that derive from this class are allowed.
    """

    def __init__(self, family: Family[Any], base: type[BaseModel] | None = None) -> None:
        self.family, self.base = family, base or family.base

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(lambda value: self.family.validated(value, self.base))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return {"oneOf": [handler(_named(model)) for model in self.family.kinds_of(self.base).values()]}


def _named(model: type[BaseModel]) -> CoreSchema:
    """Return the core schema (pydantic's description) of a model, registered under one name, so that the JSON schema of a
    case contains the model only once."""
    schema = model.__pydantic_core_schema__
    if schema["type"] == "definitions":
        return schema
    name = schema.get("ref", f"{model.__module__}.{model.__qualname__}:{id(model)}")
    definition = cast(CoreSchema, {**schema, "ref": name})
    return core_schema.definitions_schema(core_schema.definition_reference_schema(name), [definition])


class OneNameOf:
    """Annotation of a text that must be a name in a table: `Annotated[str, OneNameOf(TABLE)]`.

    entries: the table, such as the `entries` of a registry; built_in: further names without an entry.
    """

    def __init__(self, entries: Mapping[str, Any], *built_in: str) -> None:
        self.entries, self.built_in = entries, built_in

    def names(self) -> list[str]:
        """Return all valid names: entries of the table and built-in names."""
        return [*self.entries, *self.built_in]

    def validated(self, value: str) -> str:
        """Return the name if it is valid; otherwise raise an error that lists the valid names."""
        if value not in self.names():
            raise PydanticKnownError("literal_error", {"expected": listed([f"'{name}'" for name in self.names()])})
        return value

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_after_validator_function(self.validated, handler(source))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return {"type": "string", "enum": self.names()}


def register(model: type[ModelType]) -> type[ModelType]:
    """Register a model as a class decorator, so that case files can name it by its `kind`. Its base class determines the
    family.

    Raises TypeError for a class without a base class of registered kinds or without a kind, ValueError for a kind that
    another class has.
    """
    families = [registry for registry in Registry.every if isinstance(registry, Family) and issubclass(model, registry.base)]
    if not families:
        bases = listed([registry.base.__name__ for registry in Registry.every if isinstance(registry, Family)])
        raise TypeError(f"{model.__name__} derives from no base class of registered kinds: derive it from one of {bases}")
    families[0].add(model)
    return model


def _home(source: Any) -> str:
    """Return module and name of a class or function as text, for comparisons."""
    what = getattr(source, "function", source)
    return f"{what.__module__}.{what.__qualname__}"


def _described(source: Any) -> str:
    """Return the name of a class or function and the file of the user that defines it, as text for messages; "pellucid" if
    the package registered it."""
    what = getattr(source, "function", source)
    file = file_of(what)
    if is_own(file) or what.__module__ == "numpy":
        return "pellucid"
    return f"`{what.__qualname__}` in {file}"
