"""One or more of every registered material and equation of state, and laws of users, in units of their usual size."""

import pytest
from user_laws import (
    CiarletGeymonatMaterial,
    FoamMaterial,
    FungMaterial,
    GentMaterial,
    KelvinVoigtMaterial,
    SofteningMaterial,
    StandardLinearMaterial,
)

from pellucid import materials
from pellucid.materials.elastic import ElasticMaterial
from pellucid.materials.eos import EQUATIONS_OF_STATE
from pellucid.materials.fluid import FluidMaterial
from pellucid.materials.hyperelastic import HyperelasticMaterial

EOS = {
    "ideal-gas": (1.2, 1e5, {"kind": "ideal-gas", "gamma": 1.4}),
    "stiffened-gas": (1000.0, 0.0, {"kind": "stiffened-gas", "gruneisen": 4.0, "p_infinity": 2.12e8}),
    "mie-gruneisen": (
        1000.0,
        1e5,
        {"kind": "mie-gruneisen", "sound_speed": 1480.0, "slope": 1.75, "gruneisen": 0.28, "carries_tension": True},
    ),
    "tait": (1000.0, 1e5, {"kind": "tait", "sound_speed": 1480.0, "exponent": 7.0, "carries_tension": True}),
}


def fluid(eos="ideal-gas", **changes):
    """A fluid with one of the equations of state above."""
    density, pressure, table = EOS[eos]
    table = table | changes.pop("eos_changes", {})
    return FluidMaterial.model_validate({"density": density, "pressure": pressure} | changes | {"eos": table})


SOFT = {"density": 1100.0, "young_modulus": 17.9e3, "poisson_ratio": 0.45}
ALUMINIUM = {"density": 2700.0, "young_modulus": 7e10, "poisson_ratio": 0.33}
BULK = {"density": 1100.0, "bulk_modulus": 6e4}
USERS = {
    "gent": GentMaterial(**BULK, shear_modulus=6e3, limit=30.0),
    "fung": FungMaterial(**BULK, shear_modulus=6e3, stiffening=0.1),
    "ciarlet-geymonat": CiarletGeymonatMaterial(density=1100.0, c1=2e3, c2=1e3, lam=5e4),
    "foam": FoamMaterial(density=1100.0, mu=6e3, lam=5e3),
    "softening": SofteningMaterial(**BULK, shear_modulus=6e3),
    "user-kelvin-voigt": KelvinVoigtMaterial(**SOFT, viscosity=10.0),
    "standard-linear": StandardLinearMaterial(**SOFT, branch_modulus=3e3, relaxation_time=0.5),
}
# every registered solid that needs no more than elastic constants
SOLIDS = {
    kind: model(**(SOFT if issubclass(model, HyperelasticMaterial) else ALUMINIUM))
    for kind, model in materials.MATERIALS.entries.items()
    if issubclass(model, ElasticMaterial)
    and not {name for name, field in model.model_fields.items() if field.is_required()} - SOFT.keys()
}
# those with parameters of their own, of about the same stiffness
SPECIAL = {
    "mooney-rivlin": BULK | {"c1": 2e3, "c2": 1e3},
    "ogden": BULK | {"shear_moduli": (6e3, 10.0, -1e3), "exponents": (1.3, 5.0, -2.0)},
    "holzapfel-gasser-ogden": BULK
    | {"shear_modulus": 5e3, "k1": 2e3, "k2": 0.8, "dispersion": 0.1, "fibres": ((2.0, 1.0, 0.0), (2.0, -1.0, 0.5))},
}
DECOUPLED = {"kind": "decoupled-neo-hookean", "young_modulus": 17.9e3, "poisson_ratio": 0.45}
TISSUE = {"kind": "holzapfel-gasser-ogden", **SPECIAL["holzapfel-gasser-ogden"]}
BRANCHES = ({"share": 0.4, "relaxation_time": 0.5}, {"share": 0.3, "relaxation_time": 0.02})
VISCOELASTIC = {
    "kelvin-voigt": ("kelvin-voigt", {"elastic": SOFT | {"kind": "neo-hookean"}, "viscosity": 10.0}),
    "kelvin-voigt-tissue": ("kelvin-voigt", {"elastic": TISSUE, "viscosity": 10.0}),
    "prony": ("prony", {"elastic": DECOUPLED, "branches": BRANCHES[:1]}),
    "prony-2": ("prony", {"elastic": {"kind": "ogden", **SPECIAL["ogden"]}, "branches": BRANCHES}),
    "prony-tissue": ("prony", {"elastic": TISSUE, "branches": BRANCHES}),
}


def material_of(kind, table):
    """A registered material."""
    return materials.MATERIALS.entries[kind].model_validate(table)


TISSUES = {kind: material_of(kind, table) for kind, table in SPECIAL.items()} | {
    name: material_of(kind, {"density": 1100.0, **table}) for name, (kind, table) in VISCOELASTIC.items()
}
INVISCID = {name: fluid(name) for name in EOS}
MATERIALS = {
    **INVISCID,
    "viscous": fluid("stiffened-gas", viscosity=8.9e-4),
    "shocked": fluid("ideal-gas", viscosity=1.0, artificial_viscosity={"quadratic": 2.0, "linear": 1.0}),
    **SOLIDS,
    **TISSUES,
    **USERS,
}
HYPERELASTIC = {name: material for name, material in MATERIALS.items() if isinstance(material, HyperelasticMaterial)}

every_material = pytest.mark.parametrize("material", MATERIALS.values(), ids=MATERIALS)
every_inviscid_fluid = pytest.mark.parametrize("material", INVISCID.values(), ids=INVISCID)
every_solid = pytest.mark.parametrize("material", SOLIDS.values(), ids=SOLIDS)
every_hyperelastic = pytest.mark.parametrize("material", HYPERELASTIC.values(), ids=HYPERELASTIC)


def unsampled():
    """Registered classes that no sample above covers."""
    missing = set(materials.MATERIALS.entries.values()) - {type(material) for material in MATERIALS.values()}
    return missing | (set(EQUATIONS_OF_STATE.entries.values()) - {type(material.eos) for material in INVISCID.values()})


# velocity gradients [1/s] that strain by up to a tenth in a step of 1 ms
RATES = {
    "squeeze": (-80.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    "swell": (30.0, 0.0, 0.0, 0.0, 30.0, 0.0, 0.0, 0.0, 30.0),
    "shear": (0.0, 90.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    "general": (-30.0, 20.0, 5.0, -10.0, 15.0, 40.0, 7.0, -3.0, -25.0),
}
