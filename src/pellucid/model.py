"""Base class of the data models of a case, and declaration of their keys: unknown keys are errors, numbers are in SI units,
and texts with units are converted."""

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Annotated, Any, get_args, get_origin

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationInfo, field_validator, model_validator

from pellucid.errors import CONTROL
from pellucid.units import check_si

AtLeastOne = Annotated[int, Field(ge=1)]
AtLeastTwo = Annotated[int, Field(ge=2)]
AtLeastThree = Annotated[int, Field(ge=3)]
Vector = Annotated[tuple[float, float, float], Field(description="three components x, y, z")]


InputFile = Annotated[str, AfterValidator(lambda path: str(Path(path).absolute()))]
"""Path of a file that a case reads, stored as an absolute path so that a copy of the case still runs. Its key is `path`: in
a case file a relative path starts from the folder of that file, elsewhere from the working folder."""


def one_or_several(names: Any) -> Any:
    """Return a tuple of names from a single name or a list of names; a case may give a single name without brackets."""
    return (names,) if isinstance(names, str) else names


class Model(BaseModel):
    """A frozen table of a case file; unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, populate_by_name=True)

    @field_validator("*", mode="before")
    @classmethod
    def _quantity_to_si(cls, value: Any, info: ValidationInfo) -> Any:
        field = cls.model_fields[str(info.field_name)]
        extra = field.json_schema_extra
        if field.annotation in (bool, bool | None) and not isinstance(value, bool | None):
            raise ValueError("must be true or false, without quotes")  # pydantic would read "no" and 0 as false
        if isinstance(value, str) and (strange := CONTROL.search(value)):
            raise ValueError(f"contains the control character {strange[0]!r}; remove it")
        if isinstance(extra, dict) and _is_numeric(field.annotation):
            return _to_si(value, str(extra.get("unit", "")))
        return value


def check(refuse: Callable[[Any], None]) -> Any:
    """Decorate a method of a `Model` that raises an error for contradicting keys, so that it is called whenever a model is
    created."""

    @wraps(refuse)
    def unchanged(model: Any) -> Any:
        refuse(model)
        return model

    return model_validator(mode="after")(unchanged)


def _is_numeric(annotation: Any) -> bool:
    """Return True if a key with this type annotation holds numbers or vectors, possibly None, and no text, tables or
    booleans."""
    if get_origin(annotation) is Annotated:  # its other arguments are what pydantic is told
        return _is_numeric(get_args(annotation)[0])
    parts = [part for part in get_args(annotation) if part not in (type(None), ...)]
    return annotation in (float, int) or (bool(parts) and all(_is_numeric(part) for part in parts))


def _to_si(value: Any, unit: str) -> Any:
    if isinstance(value, bool):
        raise ValueError("must be a number, not a boolean")  # pydantic would read true as 1
    if isinstance(value, int) and abs(value) > LARGEST:
        raise ValueError(
            f"must be at most {LARGEST:.0e}; write a larger number with a decimal point, such as 1.0e19"
        )  # no float may hold it
    if isinstance(value, str):
        from pellucid.units import to_si  # pint is heavy: only where a unit string enters

        return to_si(value, unit)
    if isinstance(value, (list, tuple)):
        return [_to_si(item, unit) for item in value]
    return value


LARGEST = 10**18
"""Largest integer: counts fit into 64 bits."""
LIMITS = ("gt", "ge", "lt", "le", "min_length", "max_length", "pattern", "alias")
"""Limits that `parameter` passes on to pydantic."""


def parameter(unit: str, text: str, default: Any = ..., **limits: Any) -> Any:
    """Declare a field of a `Model`: unit (SI, "" for a pure number), meaning, default, limits (gt, ge, lt, le).

    Raises UnitError for a unit that is unknown or not an SI unit, TypeError for an unknown limit.
    """
    check_si(unit)
    if unknown := sorted(limits.keys() - set(LIMITS)):
        raise TypeError(f"`parameter` has no limit `{unknown[0]}`; use one of {', '.join(LIMITS)}")
    return Field(default, description=text, json_schema_extra={"unit": unit}, **limits)


LONGEST_NAME = 100
"""Largest number of characters of a name: file names may have up to 255 characters, including their extensions."""


def name_parameter(text: str, default: Any = ...) -> Any:
    """Declare a field of a `Model` that contains a name of a body, a column or a file; text: its meaning; default: its value if
    the case omits the key."""
    return parameter("", text, default, pattern=r"^[A-Za-z][A-Za-z0-9_-]*$", max_length=LONGEST_NAME)
