"""What material points ask of a material: answered by every registered one."""

from typing import get_args

import pytest
from pydantic import TypeAdapter, ValidationError
from samples import MATERIALS, SOLIDS, every_material, fluid

from pellucid import materials
from pellucid.materials.contract import PointMaterial
from pellucid.state import FIELDS


def test_each_is_registered_under_its_own_kind():
    for registered in (materials.MATERIALS, materials.MEMBRANE_MATERIALS):
        for kind, model in registered.entries.items():
            assert model.model_fields["kind"].default == kind
            assert get_args(model.model_fields["kind"].annotation) == (kind,)


def test_the_kind_chooses_among_the_registered():
    table = {"kind": "neo-hookean", "density": 1100.0, "young_modulus": 17.9e3, "poisson_ratio": 0.45}
    assert TypeAdapter(materials.Material).validate_python(table) == SOLIDS["neo-hookean"]
    with pytest.raises(ValidationError, match="'fluid', 'linear-elastic', 'neo-hookean'"):
        TypeAdapter(materials.Material).validate_python(table | {"kind": "neo-hokean"})
    with pytest.raises(ValidationError, match="'linear-membrane', 'neo-hookean-membrane'"):
        TypeAdapter(materials.AnySolidMembraneMaterial).validate_python(table)


def test_a_material_says_its_law_state_and_waves():
    class Nothing(PointMaterial):
        kind: str = "nothing"

    with pytest.raises(TypeError, match=r"abstract methods? .*initial_state.*law.*wave_speeds"):
        Nothing(density=1.0)


@every_material
def test_answers(material):
    assert material.energy_kind in ("internal", "strain")
    assert material.state_fields[0] == "stress"
    assert material.energy_field in material.probed_fields
    for name in {*material.probed_fields, *material.state_fields}:
        assert name in FIELDS
    speed, spread = material.signals(0.01)
    pressure, shear = material.wave_speeds()
    # an instantaneous modulus may be stiffer than the one at rest
    assert speed >= pressure * (1.0 - 1e-12)
    assert pressure > shear >= 0.0
    assert spread >= 0.0
    assert not list(material.problems())


@pytest.mark.parametrize(
    ("name", "fields"),
    [
        ("ideal-gas", ("internal_energy",)),
        ("linear-elastic", ("strain_energy",)),
        ("neo-hookean", ("strain_energy",)),
        ("holzapfel-gasser-ogden", ("strain_energy",)),
        ("kelvin-voigt", ("strain_energy", "dissipated_energy")),
        ("prony", ("strain_energy", "dissipated_energy", "overstress_energy_1", "overstress_1")),
        ("user-kelvin-voigt", ("internal_energy", "viscous_work")),
        ("standard-linear", ("internal_energy", "overstress")),
    ],
)
def test_probed_fields(name, fields):
    """The energy, whether carried or worked out; of what is carried, what can be made one number: no deformation gradient."""
    assert MATERIALS[name].probed_fields == fields


def test_a_fluid_pulled_until_it_has_no_sound_is_unfit():
    pulled = fluid("ideal-gas", pressure=-1.0)
    assert [key for key, _, _ in pulled.problems()] == ["pressure"]
    text, remedy = next(pulled.problems())[1:]
    assert "no real sound speed at density 1.2 kg/m^3" in text
    assert "increase the pressure" in remedy
