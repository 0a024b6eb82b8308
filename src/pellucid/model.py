"""The base of every data model of a case: strict keys, SI numbers, unit strings at the boundary."""

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, model_validator

Vector = Annotated[tuple[float, float, float], Field(description="three components x, y, z")]


class Model(BaseModel):
    """A frozen table of a case file; unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, populate_by_name=True)

    @model_validator(mode="before")
    @classmethod
    def _unit_strings_to_si(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        converted = dict(data)
        for name, info in cls.model_fields.items():
            extra = info.json_schema_extra
            if isinstance(extra, dict) and "unit" in extra and name in converted:
                converted[name] = _to_si(converted[name], str(extra["unit"]))
        return converted


def _to_si(value: Any, unit: str) -> Any:
    if isinstance(value, str):
        from pellucid.units import to_si  # pint is heavy: only where a unit string enters

        return to_si(value, unit)
    if isinstance(value, (list, tuple)):
        return [_to_si(item, unit) for item in value]
    return value


def parameter(unit: str, text: str, default: Any = ..., **limits: Any) -> Any:
    """Declare a field of a `Model` once: unit (SI, "" for a pure number), meaning, default, limits (gt, ge, lt, le)."""
    return Field(default, description=text, json_schema_extra={"unit": unit}, **limits)
