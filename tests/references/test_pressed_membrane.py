"""The membrane between plates: its table, and the script that writes it beside exact solutions."""

from pathlib import Path
from types import ModuleType

import pytest

from pellucid.references.membranes import INFLATION, POISSON_RATIO, PressedSphere

SCRIPT = Path(__file__).parents[2] / "validation" / "cells-oocyte-between-plates" / "exact.py"
SPHERE = PressedSphere(young_modulus=17.9e3, thickness=8e-6, radius=50e-6)


@pytest.fixture(scope="module")
def script() -> ModuleType:
    module = ModuleType("exact")
    module.__file__ = str(SCRIPT)
    exec(SCRIPT.read_text(encoding="utf-8"), module.__dict__)
    return module


def test_a_sphere_that_is_not_pressed_has_the_pressure_of_its_stretch() -> None:
    # sigma = E/(1 - nu) times a strain of 2 %, less 6 % by the law; p = 2 sigma h/a
    linear = 2.0 * 17.9e3 / (1.0 - POISSON_RATIO) * INFLATION * 8e-6 / 50e-6
    assert SPHERE.pressure(0.0) == pytest.approx(linear, rel=0.07)
    assert SPHERE.force(0.0) == 0.0
    assert SPHERE.equator(0.0) == 50e-6


@pytest.mark.parametrize("displacement", [0.08, 0.16, 0.32])
def test_shooting_agrees_with_the_table(script: ModuleType, displacement: float) -> None:
    sheet = script.Sheet(script.NeoHookean(POISSON_RATIO), INFLATION)
    way, force, pressure = script.shot(sheet, script.Chain(sheet, 100).press(displacement))
    one = PressedSphere(1.0, 1.0, 1.0)
    assert force == pytest.approx(one.force(way), rel=1e-3)
    assert pressure == pytest.approx(one.pressure(way), rel=2e-4)


@pytest.mark.parametrize("displacement", [0.08, 0.24])
def test_a_film_of_constant_tension_is_a_drop(script: ModuleType, displacement: float) -> None:
    force, contact = script.drop(displacement)
    found = script.Chain(script.Sheet(script.Film(POISSON_RATIO)), 60).press(displacement)
    assert found.force == pytest.approx(force, rel=3e-3)
    assert found.contact == pytest.approx(contact, rel=3e-3)


def test_a_drop_hardly_pressed_has_its_pressure_on_the_contact(script: ModuleType) -> None:
    force, contact = script.drop(0.001)
    assert force == pytest.approx(2.0 * 3.14159 * contact**2, rel=5e-3)


def test_displacements_beyond_the_table_are_refused() -> None:
    with pytest.raises(ValueError, match=r"0\.4 radii"):
        SPHERE.force(25e-6)
