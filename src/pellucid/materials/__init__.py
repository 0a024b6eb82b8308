"""Materials: one file each, with the user's parameters, the material law, its wave speed and its energy.

The kinds that a case can name are registered here, one line each.
"""

from typing import Annotated

from pellucid.materials.arruda_boyce_membrane import ArrudaBoyceMembraneMaterial
from pellucid.materials.contract import MATERIALS, PointMaterial
from pellucid.materials.decoupled_neo_hookean import DecoupledNeoHookeanMaterial
from pellucid.materials.evans_skalak_membrane import EvansSkalakMembraneMaterial
from pellucid.materials.fluid import FluidMaterial
from pellucid.materials.fluid_membrane import FluidMembraneMaterial
from pellucid.materials.holzapfel_gasser_ogden import HolzapfelGasserOgdenMaterial
from pellucid.materials.holzapfel_gasser_ogden_membrane import HolzapfelGasserOgdenMembraneMaterial
from pellucid.materials.kelvin_voigt import KelvinVoigtMaterial
from pellucid.materials.linear_elastic import LinearElasticMaterial
from pellucid.materials.linear_membrane import LinearMembraneMaterial
from pellucid.materials.membrane_material import MEMBRANE_MATERIALS, MembraneMaterial, SolidMembraneMaterial
from pellucid.materials.mooney_rivlin import MooneyRivlinMaterial
from pellucid.materials.mooney_rivlin_membrane import MooneyRivlinMembraneMaterial
from pellucid.materials.neo_hookean import NeoHookeanMaterial
from pellucid.materials.neo_hookean_membrane import NeoHookeanMembraneMaterial
from pellucid.materials.ogden import OgdenMaterial
from pellucid.materials.ogden_membrane import OgdenMembraneMaterial
from pellucid.materials.prony import PronyMaterial
from pellucid.materials.skalak_membrane import SkalakMembraneMaterial
from pellucid.materials.surface_neo_hookean_membrane import SurfaceNeoHookeanMembraneMaterial
from pellucid.materials.yeoh_membrane import YeohMembraneMaterial
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
AnySolidMembraneMaterial = Annotated[SolidMembraneMaterial, OneOf(MEMBRANE_MATERIALS, SolidMembraneMaterial)]

MEMBRANE_MATERIALS.add(LinearMembraneMaterial)
MEMBRANE_MATERIALS.add(NeoHookeanMembraneMaterial)
MEMBRANE_MATERIALS.add(SurfaceNeoHookeanMembraneMaterial)
MEMBRANE_MATERIALS.add(SkalakMembraneMaterial)
MEMBRANE_MATERIALS.add(EvansSkalakMembraneMaterial)
MEMBRANE_MATERIALS.add(MooneyRivlinMembraneMaterial)
MEMBRANE_MATERIALS.add(YeohMembraneMaterial)
MEMBRANE_MATERIALS.add(OgdenMembraneMaterial)
MEMBRANE_MATERIALS.add(ArrudaBoyceMembraneMaterial)
MEMBRANE_MATERIALS.add(HolzapfelGasserOgdenMembraneMaterial)
MEMBRANE_MATERIALS.add(FluidMembraneMaterial)
