"""Materials: one file each, with the parameters a user gives, the law, its wave speed and its energy.

The kinds that a case can name are listed here: one line each.
"""

from typing import Annotated

from pellucid.materials.contract import MATERIALS, PointMaterial
from pellucid.materials.decoupled_neo_hookean import DecoupledNeoHookeanMaterial
from pellucid.materials.elastic_membrane import ElasticMembraneMaterial
from pellucid.materials.fluid import FluidMaterial
from pellucid.materials.fluid_membrane import FluidMembraneMaterial
from pellucid.materials.holzapfel_gasser_ogden import HolzapfelGasserOgdenMaterial
from pellucid.materials.kelvin_voigt import KelvinVoigtMaterial
from pellucid.materials.linear_elastic import LinearElasticMaterial
from pellucid.materials.linear_membrane import LinearMembraneMaterial
from pellucid.materials.membrane_material import MEMBRANE_MATERIALS, MembraneMaterial
from pellucid.materials.mooney_rivlin import MooneyRivlinMaterial
from pellucid.materials.neo_hookean import NeoHookeanMaterial
from pellucid.materials.neo_hookean_membrane import NeoHookeanMembraneMaterial
from pellucid.materials.ogden import OgdenMaterial
from pellucid.materials.prony import PronyMaterial
from pellucid.registry import OneOf

Material = Annotated[PointMaterial, OneOf(MATERIALS)]

MATERIALS.add(FluidMaterial)
MATERIALS.add(LinearElasticMaterial)
MATERIALS.add(NeoHookeanMaterial)
MATERIALS.add(DecoupledNeoHookeanMaterial)
MATERIALS.add(MooneyRivlinMaterial)
MATERIALS.add(OgdenMaterial)
MATERIALS.add(HolzapfelGasserOgdenMaterial)
MATERIALS.add(KelvinVoigtMaterial)
MATERIALS.add(PronyMaterial)

AnyMembraneMaterial = Annotated[MembraneMaterial, OneOf(MEMBRANE_MATERIALS)]
AnyElasticMembraneMaterial = Annotated[ElasticMembraneMaterial, OneOf(MEMBRANE_MATERIALS, ElasticMembraneMaterial)]

MEMBRANE_MATERIALS.add(LinearMembraneMaterial)
MEMBRANE_MATERIALS.add(NeoHookeanMembraneMaterial)
MEMBRANE_MATERIALS.add(FluidMembraneMaterial)
