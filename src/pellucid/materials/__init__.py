"""Materials: one file each, with the parameters a user gives, the law, its wave speed and its energy."""

from typing import Annotated

from pydantic import Discriminator, Tag

from pellucid.materials.fluid import FluidMaterial
from pellucid.materials.linear_elastic import LinearElasticMaterial
from pellucid.materials.linear_membrane import LinearMembraneMaterial
from pellucid.materials.neo_hookean import NeoHookeanMaterial
from pellucid.materials.neo_hookean_membrane import NeoHookeanMembraneMaterial
from pellucid.model import kind_of

Material = Annotated[
    Annotated[FluidMaterial, Tag("fluid")]
    | Annotated[LinearElasticMaterial, Tag("linear-elastic")]
    | Annotated[NeoHookeanMaterial, Tag("neo-hookean")],
    Discriminator(kind_of),
]

MembraneMaterial = Annotated[
    Annotated[LinearMembraneMaterial, Tag("linear-membrane")]
    | Annotated[NeoHookeanMembraneMaterial, Tag("neo-hookean-membrane")],
    Discriminator(kind_of),
]
