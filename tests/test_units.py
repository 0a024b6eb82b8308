import subprocess
import sys
import time

import pytest

from pellucid import units
from pellucid.units import UnitError, to_si


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("3 kPa", "Pa", 3000.0),
        ("8 um", "m", 8e-6),
        ("8 µm", "m", 8e-6),
        ("1 g/cm^3", "kg/m^3", 1000.0),
        ("-2.5 mm/s", "m/s", -2.5e-3),
        ("60 rpm", "rad/s", 6.283185307179586),
        ("1e-3 s", "s", 1e-3),
        ("1 mPa*s", "Pa*s", 1e-3),
        ("20 degC", "K", 293.15),
        ("1.5e3 kg m^-3", "kg/m^3", 1500.0),
        ("2*kg*(cm/s)^2", "J", 2e-4),
        ("3 (kPa)", "Pa", 3000.0),
        ("5 m²", "m^2", 5.0),
        ("5 %", "", 0.05),
    ],
)
def test_a_text_with_a_unit_becomes_its_si_number(text: str, unit: str, value: float) -> None:
    assert to_si(text, unit) == pytest.approx(value, rel=1e-14)


def test_frequent_units_are_read_as_by_pint(monkeypatch: pytest.MonkeyPatch) -> None:
    frequent = [(si, unit) for si, factors in units._FACTORS.items() for unit in factors]
    numbers = [f"{sign}{digits}{power}" for sign in ("", "-") for digits in ("0.1", "2.7", "33", ".7") for power in ("", "e-7")]
    read = [to_si(f"{number} {unit}", si) for si, unit in frequent for number in numbers]
    monkeypatch.setattr(units, "_FACTORS", {})
    assert read == [to_si(f"{number} {unit}", si) for si, unit in frequent for number in numbers], "the same bits"


@pytest.mark.parametrize(
    ("text", "unit", "words"),
    [
        ("1 kg", "m", ["dimension [mass]", "[length] (m)", '"1 m"']),
        ("3 Pascals", "Pa", ['unknown unit "Pascals"', 'did you mean "Pa"?']),
        ("3 kpa", "Pa", ['unknown unit "kpa"', 'did you mean "kPa"?']),
        ("3", "Pa", ["has no unit", "3 without quotes", '"3 Pa"']),
        ("0.5", "", ["0.5 without quotes"]),
        ("3 ++ m", "m", ['cannot read "3 ++ m"']),
        ("3 (m", "m", ['cannot read "3 (m"']),
        ("1/0 m", "m", ['cannot read "1/0 m"']),
        ("fast", "m/s", ['"fast" is not a number', '"1 m/s"']),
        ("", "m", ["is not a number"]),
        ("5 m", "", ["[length]", "a pure number"]),
    ],
)
def test_what_is_no_such_quantity_is_explained(text: str, unit: str, words: list[str]) -> None:
    with pytest.raises(UnitError) as caught:
        to_si(text, unit)
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize(
    "text",
    [
        "9**9**9 s",
        "2**3 s",
        "1 s^999999999",
        "1 s**9**9**9",
        "3 cm + 2 mm",
        "1 s; import os",
        "1" * 5000 + " s",
        "(" * 3000 + "1" + ")" * 3000 + " s",
        "1 s" + "*s/s" * 3000,
        "5 " + "x" * 100_000,
        "3 s\0",
    ],
)
def test_a_text_is_parsed_and_never_calculated(text: str) -> None:
    start = time.process_time()
    with pytest.raises(UnitError, match="cannot read"):
        to_si(text, "s")
    assert time.process_time() - start < 2.0


def test_pint_is_imported_only_where_a_unit_is_met() -> None:
    source = (
        "import sys, pellucid.units; assert 'pint' not in sys.modules; "
        "pellucid.units.to_si('1 mm', 'm'); assert 'pint' not in sys.modules; "
        "pellucid.units.to_si('1 inch', 'm'); assert 'pint' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", source], check=True)
