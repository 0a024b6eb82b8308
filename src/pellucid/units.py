"""Units of user input: "3 kPa" is converted to 3000.0; inside the package all numbers are in SI units. Imports pint only
when needed."""

import difflib
import re
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from math import degrees
from tokenize import TokenError
from typing import Any

from pellucid.errors import cut

COMMON = (
    "m cm mm um nm km s ms us ns min h kg g mg N kN mN uN Pa kPa MPa GPa bar mbar atm psi J kJ mJ W K degC rad deg rpm "
    "Hz kHz MHz m/s mm/s km/h m/s^2 kg/m^3 g/cm^3 Pa*s mPa*s J/kg kJ/kg N/m"
)

_SI = r"(?:m|kg|s|A|K|mol|rad|N|Pa|J|W|Hz|V|C|F|T|H)(?:\^-?[1-9])?"
_COHERENT = re.compile(rf"(?:1|{_SI})(?:[*/]{_SI})*(?:/\({_SI}(?:\*{_SI})*\))?")
"""Pattern of products of SI units, optionally divided by a product in brackets, which need no check by pint."""


LONGEST = 60
"""Largest number of characters of a quantity."""
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_POWER = r"(?:\s*(?:\^|\*\*)\s*[+-]?\d)?"
_TERM = rf"(?:[^\W\d_]\w*|1|%|°C){_POWER}"
_TERMS = rf"{_TERM}(?:(?:\s*[*/]\s*|\s+){_TERM})*"
_FACTOR = rf"(?:{_TERM}|\(\s*{_TERMS}\s*\){_POWER})"
_QUANTITY = re.compile(rf"\s*(?P<number>{_NUMBER})\s*\*?\s*(?P<unit>{_FACTOR}(?:(?:\s*[*/]\s*|\s+){_FACTOR})*)\s*")
"""Pattern of a number and a product of powers of units, without expressions that pint would evaluate."""
_PINT_RAISES = (ArithmeticError, AssertionError, AttributeError, SyntaxError, TokenError, TypeError, ValueError)

_FACTORS: dict[str, dict[str, float]] = {
    "m": {"m": 1.0, "cm": 0.01, "mm": 0.001, "um": 1e-6, "µm": 1e-6, "nm": 1e-9, "km": 1000.0},
    "s": {"s": 1.0, "ms": 0.001, "us": 1e-6, "µs": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0},
    "kg": {"kg": 1.0, "g": 0.001, "mg": 1e-6},
    "N": {"N": 1.0, "kN": 1000.0, "mN": 0.001, "uN": 1e-6, "µN": 1e-6, "nN": 1e-9, "pN": 1e-12},
    "N/m": {"N/m": 1.0, "mN/m": 0.001, "uN/m": 1e-6},
    "Pa": {"Pa": 1.0, "kPa": 1000.0, "MPa": 1e6, "GPa": 1e9, "bar": 1e5, "mbar": 100.0},
    "Pa*s": {"Pa*s": 1.0, "mPa*s": 0.001},
    "J": {"J": 1.0, "kJ": 1000.0, "mJ": 0.001},
    "m/s": {"m/s": 1.0, "mm/s": 0.001},
    "m/s^2": {"m/s^2": 1.0},
    "kg/m^3": {"kg/m^3": 1.0},
    "m^3": {"m^3": 1.0},
}
"""Factors of frequent units by SI unit, equal to those of pint, which takes half a second to start."""


class UnitError(ValueError):
    """Error for a text that is not a quantity of the required dimension."""


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry(autoconvert_offset_to_baseunit=True)


def to_si(text: str, unit: str) -> float:
    """Return the value of `text`, such as "3 kPa", in the SI unit `unit`, such as "Pa" ("" for a pure number).

    Raises UnitError if the text cannot be read, has no unit, or has a unit of another dimension.
    """
    said = cut(text, LONGEST)
    if '"' in text or "'" in text:
        raise UnitError(f"{said} contains a quotation mark; remove it")
    if not any(character.isdigit() for character in text):
        raise UnitError(f'"{said}" is not a number' + (f" with a unit, such as {_example(unit)}" if unit else ""))
    if _is_number(text):
        wanted = f'or add a unit, such as "{said.strip()} {unit}"' if unit else "the value has no unit"
        raise UnitError(f'the text "{said}" has no unit; write {said.strip()} without quotes, {wanted}')
    kind = f"a number with a unit, such as {_example(unit)}" if unit else "a number"
    found = _QUANTITY.fullmatch(text) if len(text) <= LONGEST else None
    if found is None:
        raise UnitError(f'cannot read "{said}" as {kind}')
    if (factor := _FACTORS.get(unit, {}).get(found["unit"])) is not None:
        return float(found["number"]) * factor

    from pint import DimensionalityError

    with _read(f' in "{said}"', f'cannot read "{said}" as {kind}'):
        quantity = _registry().Quantity(float(found["number"]), _registry().Unit(found["unit"]))
    try:
        return float(quantity.to(unit or "dimensionless").magnitude)
    except DimensionalityError:
        raise UnitError(
            f'"{said}" has the dimension {quantity.dimensionality}, but {_wanted(unit)} is required, such as {_example(unit)}'
        ) from None


def in_degrees(angle: Any) -> Any:
    """Return an angle in degrees; input: a number in degrees or a text with a unit."""
    return degrees(to_si(angle, "rad")) if isinstance(angle, str) else angle


def check_si(unit: str) -> None:
    """Raise UnitError for a text that is not a coherent SI unit, such as "kPa" or "Pas"; "" and "1" mean pure numbers."""
    if not isinstance(unit, str):
        raise UnitError(f'the unit must be a text, such as "kg/m^3", but it is {unit!r}')
    if not unit or _COHERENT.fullmatch(unit):
        return
    with _read("", f'cannot read "{unit}" as a unit, such as "kg/m^3"'):
        factor = _registry().Quantity(1.0, _registry().Unit(unit)).to_base_units()
    if abs(factor.magnitude - 1.0) > 1e-12:
        raise UnitError(
            f'"{unit}" is not an SI unit without prefix; declare one such as "kg/m^3" (case files may still use "1 {unit}")'
        )


@contextmanager
def _read(place: str, unreadable: str) -> Iterator[None]:
    """Context manager that raises UnitError for errors of pint in the block. unreadable: message for a text that cannot be
    read; place: description of where a unit is unknown, for the message."""
    from pint import PintError, UndefinedUnitError

    try:
        yield
    except UndefinedUnitError as error:
        names: Any = error.unit_names  # one name or several, whatever its annotation says
        name = names if isinstance(names, str) else str(names[0])
        raise UnitError(f'unknown unit "{name}"{place}{_suggestion(name)}') from None
    except (*_PINT_RAISES, PintError):
        raise UnitError(unreadable) from None


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _wanted(unit: str) -> str:
    return f"{_registry().Unit(unit).dimensionality} ({unit})" if unit else "a pure number"


def _example(unit: str) -> str:
    return f'"1 {unit}"' if unit else "0.5"


def _suggestion(name: str) -> str:
    common = COMMON.split()
    same = [unit for unit in common if unit.lower() == name.lower()]
    close = same or _symbol(name) or difflib.get_close_matches(name, common, 1)
    return f'; did you mean "{close[0]}"?' if close else ""


def _symbol(name: str) -> list[str]:
    """Return the symbol of a unit in capital letters, such as "Pascals", as a list; an empty list if there is none."""
    from pint import PintError

    try:
        return [f"{_registry().Unit(name.lower()):~}"]
    except (*_PINT_RAISES, PintError):
        return []
