"""Laws of users that lack something or fail: told when the case is read, before a kernel is compiled."""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from registries import forgotten_afterwards
from typer.testing import CliRunner
from user_files import CASE, told

from pellucid.cli import app
from pellucid.results.storage.run import Run

LAW = """\
from math import sqrt
from typing import Literal, NamedTuple

from pellucid.extend import ElasticMaterial, PointMaterial, register
from pellucid.jit import point_function
from pellucid.materials.law import rate_type, signal_speed, stored_energy, update
from pellucid.materials.point_state import point_state
from pellucid.tensors import NO_STRESS, Symmetric, add, scale, symmetric_part


@rate_type
class Soft(NamedTuple):
    modulus: float


@point_state()
class SoftState(NamedTuple):
    stress: Symmetric
    strain_energy: float


@register
class SoftMaterial(ElasticMaterial, PointMaterial):
    kind: Literal["soft"] = "soft"

    def law(self):
        return Soft(self.young_modulus)

    def initial_state(self):
        return SoftState(NO_STRESS, 0.0)


@point_function(update, Soft)
def _update(law, state, density, L, dt, length):
    return SoftState(add(state.stress, scale(law.modulus * dt, symmetric_part(L))), state.strain_energy)


@point_function(stored_energy, Soft)
def _stored_energy(law, state, density):
    return state.strain_energy


@point_function(signal_speed, Soft)
def _signal_speed(law, state, density, L, length):
    return sqrt(2.0 * law.modulus / density)
"""
HEAD, SOFT = "".join(CASE.partition("[[body]]")[:1]), 'kind = "soft", density = 1000, young_modulus = 1e5, poisson_ratio = 0.3'
BLOCK = '[[body]]\nname = "block"\nshape = { box = { lower = [0.5, 0.5, 0], upper = [1.5, 1.5, 0] } }\n'


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.chdir(tmp_path)
    with forgotten_afterwards():
        yield tmp_path


def law_told(folder: Path, before: str = "", after: str = "", law: str = LAW, material: str = SOFT, body: str = BLOCK) -> str:
    """What `pellucid validate` says of a body whose law has a mistake."""
    assert before in law
    (folder / "mine.py").write_text(law.replace(before, after), encoding="utf-8")
    (folder / "case.toml").write_text(f"{HEAD}{body}material = {{ {material} }}\n", encoding="utf-8")
    return told(2, "validate", "case.toml")


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        (
            "@rate_type\n",
            "",
            ["law Soft (", "mine.py) has no `volume_growth`, `diffusivity`, ", "; decorate it with `@rate_type`"],
        ),
        ("@point_function(update, Soft)\n", "", ["has no `update`; register each, as `@point_function(update, Soft)`"]),
        (
            "return state.strain_energy",
            "return None",
            ["`stored_energy` of the law Soft", "returns None at rest; it must return a number"],
        ),
        (
            "2.0 * law.modulus",
            "-law.modulus",
            ["`signal_speed` of", "ValueError: math domain error, at ", "mine.py:45 (`return sqrt("],
        ),
        ("return sqrt(", "return -(", ["returns -200.0 at rest; it must return a finite number, not below 0"]),
        ("return SoftState(add", "return (add", ["`update` of the law Soft", "returns a tuple; it must return a SoftState"]),
        (
            "SoftState(NO_STRESS",
            "SoftState(NO_STRESS[:3]",
            ["SoftMaterial.initial_state: `stress` is (0.0, 0.0, 0.0); it must be a tuple of 6 numbers"],
        ),
        ("@point_state()\n", "", ["is not a state of a point: decorate it with `@point_state()`"]),
        ("Soft(self.young_modulus)", "Soft(self.kind)", [".modulus = 'soft' is not a number; kernels accept numbers"]),
        ("Soft(self.young_modulus)", "self.young_modulus", ["SoftMaterial gives the law 100000.0; it must be a NamedTuple"]),
        (
            "Soft(self.young_modulus)",
            "Soft(self.stiffness)",
            ["SoftMaterial.law fails: AttributeError", "mine.py:27 (`return Soft(self.stiff"],
        ),
        (
            '"soft"\n',
            '"soft"\n    energy_kind = "heat"\n',
            ['SoftMaterial.energy_kind = "heat" must be "internal" or "strain"'],
        ),
    ],
)
def test_a_law_is_tried_at_rest_when_the_case_is_read(before: str, after: str, words: list[str], folder: Path) -> None:
    message = law_told(folder, before, after)
    for word in ("case.toml:17: body.block.material = { kind =", *words):
        assert word in message


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("Soft(NamedTuple)", "Soft", "line 11: TypeError: Soft is not a NamedTuple: kernels require the parameters"),
        ("state, density):", "state):", "`stored_energy`, _stored_energy(law, state, density)"),
        (
            "(update, Soft)",
            "(sqrt, Soft)",
            "line 33: TypeError: sqrt is not an operation for which a law can register a function",
        ),
        ("    def law(self):\n        return Soft(self.young_modulus)\n", "", "SoftMaterial does not define `law`"),
        ("@point_state()", '@point_state(strain_energy=("J/lb", "energy"))', 'UnitError: "J/lb" is not an SI unit'),
    ],
)
def test_a_law_at_registration(before: str, after: str, words: str, folder: Path) -> None:
    assert words in law_told(folder, before, after)


def test_a_hyperelastic_law_states_three_functions(folder: Path) -> None:
    law = re.sub(r"\n\n@point_function.*", "", LAW, flags=re.DOTALL).replace("rate_type", "hyperelastic")
    law = law.replace("materials.law import hyperelastic, ", "materials.law import ").replace(
        "PointMaterial", "HyperelasticMaterial"
    )
    law = "from pellucid.materials.hyperelastic import HyperelasticMaterial, hyperelastic\n" + law.replace(
        ", HyperelasticMaterial, r", ", r"
    )
    law = law.replace("    def initial_state(self):\n        return SoftState(NO_STRESS, 0.0)\n", "")
    words = "has no `coupled_energy`; register each, as `@point_function(coupled_energy, Soft)`; `energy`, `cauchy_stress`, "
    words += "`wave_speed` follow from `coupled_energy` or can be registered instead of it"
    assert words in law_told(folder, law=law)


def test_an_equation_of_state_states_three_functions(folder: Path) -> None:
    equation = """\
from typing import Literal, NamedTuple

from pellucid.extend import EquationOfStateModel, register


class Stiff(NamedTuple):
    modulus: float


@register
class StiffCase(EquationOfStateModel):
    kind: Literal["stiff"] = "stiff"

    def law(self, density, pressure):
        return Stiff(1e6)
"""
    fluid = 'kind = "fluid", density = 1000, eos = { kind = "stiff" }'
    message = law_told(folder, law=equation, material=fluid)
    assert "the law Stiff (" in message
    assert (
        "has no `pressure_line`, `lowest_pressure`, `sound_speed`; register each, as `@point_function(pressure_line" in message
    )
    message = law_told(folder, "Stiff(1e6)", "Stiff(1e6 / 0)", law=equation, material=fluid)
    assert "FluidMaterial.law fails: ZeroDivisionError: float division by zero, at " in message
    assert "mine.py:15 (`return Stiff(1e6 / 0)`)" in message


def test_a_law_of_a_membrane_states_eight_functions(folder: Path) -> None:
    law = """\
from typing import Literal, NamedTuple

from pellucid.extend import ElasticMembraneMaterial, register
from pellucid.jit import implementation_of, point_function
from pellucid.materials import membrane
from pellucid.materials.linear_membrane import LinearMembrane


class Foil(NamedTuple):
    E: float
    nu: float


@register
class FoilMaterial(ElasticMembraneMaterial):
    kind: Literal["foil"] = "foil"

    def elastic_law(self):
        return Foil(self.young_modulus, self.poisson_ratio)


for operation in (membrane.initial_shape, membrane.stretched, membrane.stretched_midway, membrane.shape_of, membrane.smoothed):
    point_function(operation, Foil)(implementation_of(operation, LinearMembrane))


@point_function(membrane.plane_response, Foil)
def _response(law, shape):
    return (0.0, 0.0, 0.0)


point_function(membrane.largest_strain, Foil)(implementation_of(membrane.largest_strain, LinearMembrane))
point_function(membrane.plane_wave_speed, Foil)(implementation_of(membrane.plane_wave_speed, LinearMembrane))
"""
    body = """\
[[body]]
name = "sheet"
kind = "membrane-elements"
thickness = 0.001
surface = { rectangle = { corner = [0, 0, 0.1], first_edge = [1, 0, 0], second_edge = [0, 1, 0], points = [5, 5] } }
"""
    foil = SOFT.replace("soft", "foil")
    last = "point_function(membrane.plane_wave_speed, Foil)"
    message = law_told(folder, last, f"# {last}", law, foil, body)
    assert "body.sheet.material" in message
    assert "the law Foil (" in message
    assert "has no `plane_wave_speed`; register each, as `@point_function(plane_wave_speed, Foil)`" in message
    message = law_told(folder, law=law, material=foil, body=body)
    assert "`plane_response` of the law Foil" in message
    assert "is (0.0, 0.0, 0.0); it must be a tuple of 4 numbers" in message
    message = law_told(folder, law=law, material=f"{foil}, wrinkling = true", body=body)
    assert "has no `unwrinkled`; register each" in message


def test_a_surface_law_states_its_energy_and_no_stress_at_rest(folder: Path) -> None:
    """The one of the page on membranes, whole and with mistakes."""
    page = (Path(__file__).parents[2] / "docs" / "physics" / "membranes.md").read_text(encoding="utf-8")
    (law,) = re.findall(r"^```python\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    body = """\
[[body]]
name = "sheet"
kind = "membrane-elements"
thickness = 0.001
surface = { rectangle = { corner = [0, 0, 0.1], first_edge = [1, 0, 0], second_edge = [0, 1, 0], points = [5, 5] } }
"""
    quadratic = 'kind = "quadratic-membrane", density = 1000, area_modulus = 2, shear_modulus = 1'
    message = law_told(folder, "@point_function(stretch_energy, Quadratic)", "", law, quadratic, body)
    assert "body.sheet.material" in message
    assert "has no `stretch_energy`; register each" in message
    message = law_told(folder, "return 0.5", "return 0.0 if a < 1.0 else 0.5", law, quadratic, body)
    assert "`stretch_energy` of the law Quadratic cannot be differentiated: it compares" in message
    assert "(`return 0.0 if a < 1.0 else" in message
    assert "register `stretch_slopes` of this law as well" in message
    slopes = (
        "\n\n@point_function(stretch_slopes, Quadratic)\ndef _slopes(law, a, b):\n    return 3.0 * (a - 1.0), 3.0 * (b - 1.0)\n"
    )
    text = law.replace("import stretch_energy", "import stretch_energy, stretch_slopes") + slopes
    message = law_told(folder, law=text, material=quadratic, body=body)
    assert "the stress of the law Quadratic (" in message
    assert "is not the derivative of its energy: at a stretch" in message
    stiff = quadratic.replace("shear_modulus = 1", "shear_modulus = -1")
    message = law_told(folder, ", gt=0)", ")", law, stiff, body)
    assert "the shear modulus of the law Quadratic (" in message
    assert "is -1 N/m at rest; it must not be below 0" in message
    message = law_told(folder, "(a + b - 2.0)", "(a + b - 1.9)", law, quadratic, body)
    assert "has a stress at rest; its energy must be smallest at rest" in message


GENT = 'kind = "gent", density = 1000, bulk_modulus = 1e5, shear_modulus = 2e4, limit = 30'


CIARLET = 'kind = "ciarlet-geymonat", density = 1000, c1 = 1e4, c2 = 0, lam = 1e5'


def law_of_the_page_on_solids(name: str = "Gent") -> str:
    page = (Path(__file__).parents[2] / "docs" / "physics" / "solids.md").read_text(encoding="utf-8")
    (law,) = (text for text in re.findall(r"^```python\n(.*?)^```", page, re.MULTILINE | re.DOTALL) if f"class {name}(" in text)
    return law


def test_an_isotropic_law_states_its_energy_alone(folder: Path) -> None:
    law = law_of_the_page_on_solids()
    message = law_told(folder, "log1p(-first / law.limit)", "max(first, 0.0)", law, GENT)
    assert "`invariant_energy` of the law Gent cannot be differentiated: it compares its arguments" in message
    assert "(`return -0.5 * law.mu" in message
    message = law_told(folder, "@point_function(invariant_energy, Gent)", "", law, GENT)
    assert "the law Gent (" in message
    assert "has no `invariant_energy`; register each, as `@point_function(invariant_energy, Gent)`" in message
    assert "`isochoric_energy`, `isochoric_stress`, `isochoric_stiffness` follow from `invariant_energy`" in message


@pytest.mark.parametrize(
    ("after", "words"),
    [
        (
            "log1p(-first / law.size)",
            ["has no attribute 'size', at", "correct the name, or add the field; the law has `mu`, `limit`, "],
        ),
        ("log1q(-first / law.limit)", ["name 'log1q' is not defined, at", "; correct the name"]),
        ("(first, second)", ["it combines a number with a tuple, at", "mine.py:"]),
        ("log1p(-first / law.limit), 0.0", ["it returns a tuple, at", "mine.py:", "; return one number, the energy"]),
        ("helper(first)\n\n\ndef helper(x):\n    return x * x", ["it calls `helper`", "; decorate `helper` with `@pointwise`"]),
        ("max(first, 0.0)", ["or register `isochoric_energy` of this law as well"]),
        ("(-log1p(-first / law.limit))", ["the shear modulus of the law Gent (", "is -20000 Pa at rest; it must be above 0"]),
        (
            "first**1.5",
            ["`invariant_slopes`, derived from `invariant_energy`, of the law Gent (", "division by zero; the deriv"],
        ),
        ("log(0.0 * law.mu)", ["`invariant_energy` of the law Gent (", "returns inf at rest; it must return a finite number"]),
    ],
)
def test_mistakes_in_an_energy(after: str, words: list[str], folder: Path) -> None:
    law = law_of_the_page_on_solids().replace("log1p,", "log, log1p,")
    message = law_told(folder, "log1p(-first / law.limit)", after, law, GENT)
    assert "warning" not in message
    assert "derived for" not in message
    for word in words:
        assert word in message, message


STATED = """

from pellucid.materials import law as laws


@point_function(laws.volumetric_energy, Gent)
def _of_volume(law, J):
    return 0.25 * law.kappa * ((J - 1.0) * (J + 1.0) - 2.0 * log(J))
"""


def test_the_stress_is_the_derivative_of_the_energy(folder: Path) -> None:
    """A volumetric energy alone is enough; a stress of another energy is refused, and one at rest."""
    law = law_of_the_page_on_solids().replace("log1p,", "log, log1p,") + STATED
    other = (
        "\n\n@point_function(laws.volumetric_stress, Gent)\ndef _pressure(law, J):\n    return law.kappa * (J - 1.0) * 1.1\n"
    )
    message = law_told(folder, "- 2.0 * log(J))", "- 2.0 * log(J))" + other, law, GENT)
    assert "the stress of the law Gent (" in message
    assert "is not the derivative of its energy: at a change of volume with strains of 1 % they differ by 1" in message
    shape = "\n\n@point_function(laws.isochoric_energy, Gent)\ndef _shape(law, F):\n    return 0.0\n"
    message = law_told(folder, "- 2.0 * log(J))", "- 2.0 * log(J))" + shape, law, GENT)
    assert "is not the derivative of its energy: at a change of shape with strains of 1 % they differ by" in message
    message = law_told(folder, "- 2.0 * log(J)", "- 2.1 * log(J)", law, GENT)
    assert "has a stress of -2.5e+03 Pa at rest; its energy must be smallest at rest" in message


def test_a_coupled_law_with_a_stress_at_rest_is_named(folder: Path) -> None:
    law = law_of_the_page_on_solids("CiarletGeymonat")
    message = law_told(folder, "4.0 * law.c2", "3.0 * law.c2", law, CIARLET.replace("c2 = 0", "c2 = 1e4"))
    assert "the law CiarletGeymonat (" in message
    assert "has a stress of 1e+04 Pa at rest; its energy must be smallest at rest: 2 W₁ + 4 W₂ + W_J must be 0 there" in message


@pytest.mark.slow
@pytest.mark.parametrize(("name", "material"), [("Gent", GENT), ("CiarletGeymonat", CIARLET)])
def test_a_law_by_its_energy_alone_runs(folder: Path, name: str, material: str) -> None:
    """A block that starts to stretch: its kinetic energy becomes strain energy, and no stress works without the energy."""
    (folder / "mine.py").write_text(law_of_the_page_on_solids(name), encoding="utf-8")
    start = 'initial = [{ kind = "velocity-gradient", x = [2, 0, 0], y = [0, -2, 0], origin = [1, 1, 0] }]\n'
    text = f"{HEAD}{BLOCK}{start}material = {{ {material} }}\n".replace("end = 0.01", "end = 0.1")
    (folder / "case.toml").write_text(f"{text}[output]\nhistory = 1e-3\n", encoding="utf-8")
    result = CliRunner().invoke(app, ["run", "case.toml", "--out", "out"])
    assert result.exit_code == 0, result.stderr
    history = Run("out").history
    total = history["strain_energy"] + history["kinetic_energy"]
    assert max(history["strain_energy"]) > 0.3 * total[0]
    assert total == pytest.approx(np.full(len(total), total[0]), rel=0.05)


@pytest.mark.slow
def test_a_law_beyond_its_limit_is_named(folder: Path) -> None:
    (folder / "mine.py").write_text(law_of_the_page_on_solids(), encoding="utf-8")
    start = 'initial = [{ kind = "velocity-gradient", x = [20, 0, 0], y = [0, -20, 0], origin = [1, 1, 0] }]\n'
    gent = GENT.replace("limit = 30", "limit = 0.01")
    text = f"{HEAD}{BLOCK}{start}material = {{ {gent} }}\n".replace("end = 0.01", "end = 0.1")
    (folder / "case.toml").write_text(text, encoding="utf-8")
    result = CliRunner().invoke(app, ["run", "case.toml", "--out", "out"])
    assert result.exit_code == 3
    assert "the energy of its law Gent is not defined at" in result.stderr
    assert "use a law or parameters that allow larger strains" in result.stderr
